"""pushes.csv: one row per k, on disk before the next push begins. Only here records become columns."""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deformpush.cell.world import Outcome
from deformpush.push_record import PushRecord
from deformpush.record.files import TABLE_BYTES, append, read_bytes, to_append, write_whole
from deformpush.task import ERROR_COLUMNS, TERMS

if TYPE_CHECKING:
    import pandas as pd

STRAIN = {f"strain_{name}": name for name in ("p99_peak", "top10_peak", "max_peak", "residual")}
"""Columns of the strain, and where an outcome has them."""
FORCE = ("tool_force_peak", "tool_force_mean")
"""Columns of the tool's force, named as an outcome names it."""
TIMES = ("step_s", "render_s", "decide_s", "record_s")
COLUMNS = [
    *("k", "phase", "kappa", "d", "xi"),
    *ERROR_COLUMNS,
    *("acq", "xi_mean", "xi_std", "kappa_min", "kappa_max", "d_min", "d_max"),
    *("steps", *TIMES),
    *(*STRAIN, "limit_exceeded"),
    "speed",
    *FORCE,
]
"""The columns of pushes.csv, in this order."""
OPTIONAL = {
    *(column for term in TERMS for column in (term.symbol, term.column)),
    *(*STRAIN, "limit_exceeded", "speed", *FORCE),
}
"""Columns that tables of other versions lack."""

TEXTS = ("phase",)
WHOLE_NUMBERS = ("k", "steps")

Cell = str | int | float | None
Row = dict[str, Any]
"""Values by column name."""
Column = list[str] | list[int] | list[float]


class Table:
    """Appends rows to a pushes.csv. Floats are written with every digit; nan is an empty cell."""

    def __init__(self, path: Path, first: PushRecord, record_s: float) -> None:
        """Write header and row 0 at once, then keep the file open for appending."""
        write_whole(path, (",".join(COLUMNS) + "\n" + line(first, record_s)).encode())
        self._file = to_append(path)

    @classmethod
    def reopen(cls, path: Path, rows: int) -> "Table":
        """Go on with a table after its first `rows` rows; what stands behind them is cut off."""
        whole = read_bytes(path, TABLE_BYTES).splitlines(keepends=True)[: rows + 1]
        table = cls.__new__(cls)
        table._file = to_append(path, sum(len(line) for line in whole))
        return table

    def append(self, record: PushRecord, record_s: float) -> None:
        """Append one row and bring it to the disk, whole or not at all.

        `record_s` is the time spent recording this push up to here: the write of the row itself is not in it.

        Raises:
            OSError: no room for the row.
        """
        append(self._file, line(record, record_s).encode(), sync=True)

    def close(self) -> None:
        """Release the file."""
        self._file.close()


def line(record: PushRecord, record_s: float) -> str:
    """Format one row, in the order of `COLUMNS`."""
    return as_line(cells(record, record_s).values())


def cells(record: PushRecord, record_s: float) -> dict[str, Cell]:
    """Values of one row by column name, in the order of `COLUMNS`; None is an empty cell."""
    action, timing = record.action, record.timing
    outcome = Outcome() if action is None else action.outcome
    values: dict[str, Cell] = dict.fromkeys(COLUMNS)
    values |= {"k": record.k, "steps": outcome.steps}
    values |= {column: record.errors[column] for column in ERROR_COLUMNS}
    values |= zip(TIMES, (outcome.step_s, timing.render_s, timing.decide_s, record_s), strict=True)
    if action is not None:
        made, (kappa, d) = action.proposal, action.u.tolist()
        (kappa_min, kappa_max), (d_min, d_max) = made.bounds.tolist()
        values |= {"phase": made.phase, "kappa": kappa, "d": d, "speed": action.path.speed, "xi": action.xi}
        values |= {"acq": made.acq, "xi_mean": made.mean, "xi_std": made.std}
        values |= {"kappa_min": kappa_min, "kappa_max": kappa_max, "d_min": d_min, "d_max": d_max}
    if (strain := outcome.strain) is not None:
        values |= {column: getattr(strain, name) for column, name in STRAIN.items()}
    values |= {column: getattr(outcome, column) for column in FORCE}
    values["limit_exceeded"] = outcome.exceeded
    return values


def as_line(values: Iterable[Cell]) -> str:
    """A line of a table: every digit of a number, nothing where there is none."""
    return ",".join(map(_text, values)) + "\n"


def _text(value: Cell) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    if isinstance(value, int):
        return str(int(value))  # true is 1
    return "" if math.isnan(value) else repr(float(value))


def read(path: Path) -> "pd.DataFrame":
    """Read a pushes.csv as a frame: `columns` of it side by side; errors as there."""
    import pandas as pd

    return pd.DataFrame(columns(path))


def read_rows(path: Path) -> list[Row]:
    """Read a pushes.csv, one dictionary per row; rows of another version's table lack what it lacks."""
    found = columns(path, all_columns=False)
    return [dict(zip(found, row, strict=True)) for row in zip(*found.values(), strict=True)]


def missing(name: str) -> str | float:
    """What an empty cell of this column is read as."""
    return "" if name in TEXTS else math.nan


def columns(path: Path, all_columns: bool = True) -> dict[str, Column]:
    """Read a pushes.csv by the names of its columns, also of a killed run: a row that was cut is left out.

    Args:
        path: the file.
        all_columns: also those of `OPTIONAL` that the table of another version lacks, as nan.

    Returns:
        The columns `COLUMNS`, then those that only another version knows, one value per k; `phase` is "" and
        the other action cells are nan in row 0.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not a table of pushes.
    """
    header, rows = read_csv(path, "pushes")
    unknown = set(COLUMNS) - OPTIONAL - set(header)
    if unknown or len(set(header)) < len(header):
        raise ValueError(f"{path}: not a table of pushes (its first line must name {', '.join(COLUMNS)})")
    found = dict(zip(header, zip(*rows, strict=True) if rows else [()] * len(header), strict=True))
    if all_columns:
        empty = ("",) * len(rows)
        found = {name: found.get(name, empty) for name in dict.fromkeys([*COLUMNS, *header])}
    return {name: column(part, name in TEXTS, name in WHOLE_NUMBERS) for name, part in found.items()}


def read_csv(path: Path, what: str) -> tuple[list[str], list[list[str]]]:
    """The header of a table of `what`, and its rows, all as long; what follows the last line end is left out.

    Raises:
        OSError: the file cannot be read, or is larger than 64 MB.
        ValueError: a row has more or fewer cells, or is no text.
    """
    text = read_bytes(path, TABLE_BYTES).decode(errors="replace")
    lines = csv.reader(io.StringIO(text[: text.rfind("\n") + 1], newline=""))
    rows: list[list[str]] = []
    try:
        header = next(lines, [])
        for row in lines:
            if len(row) != len(header):
                where = f"line {lines.line_num} has {len(row)} cells"
                raise ValueError(f"{path}: not a table of {what} ({where}, the first {len(header)})")
            rows.append(row)
    except csv.Error as error:
        raise ValueError(f"{path}: not a table of {what} ({error})") from error
    return header, rows


def column(cells: Sequence[str], texts: bool, whole_numbers: bool) -> Column:
    """What the cells of a column say; an empty one is nan, or no text.

    Raises:
        ValueError: a cell is no number.
    """
    # Python's own conversions are exact in both directions; pandas' parsers differ between versions.
    if texts:
        return list(cells)
    if whole_numbers:
        return [int(cell) for cell in cells]
    return [float(cell or "nan") for cell in cells]
