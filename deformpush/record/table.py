"""pushes.csv: one row per k, on disk before the next push begins."""

import csv
import errno
import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deformpush.push_record import COLUMNS, PushRecord
from deformpush.record.folder import write_whole

if TYPE_CHECKING:
    import pandas as pd

WORDS = ("phase",)
WHOLE_NUMBERS = ("k", "steps")
STRAIN = {f"strain_{name}": name for name in ("p99_peak", "top10_peak", "max_peak", "residual")}
"""Columns of the strain, and where the record has them."""
WITHOUT_STRAIN = COLUMNS.index("strain_p99_peak")
"""Number of columns in tables of versions that did not measure the strain."""

Column = list[str] | list[int] | list[float]


class Table:
    """Appends rows to a pushes.csv. Floats are written with every digit; nan is an empty cell."""

    def __init__(self, path: Path, first: PushRecord, record_s: float) -> None:
        """Write header and row 0 at once, then keep the file open for appending."""
        write_whole(path, (",".join(COLUMNS) + "\n" + line(first, record_s)).encode())
        self._file = path.open("ab", buffering=0)

    @classmethod
    def reopen(cls, path: Path, rows: int) -> "Table":
        """Go on with a table after its first `rows` rows; what stands behind them is cut off."""
        whole = path.read_bytes().splitlines(keepends=True)[: rows + 1]
        table = cls.__new__(cls)
        table._file = path.open("r+b", buffering=0)
        table._file.truncate(sum(len(line) for line in whole))
        table._file.seek(0, os.SEEK_END)
        return table

    def append(self, record: PushRecord, record_s: float) -> None:
        """Append one row and bring it to the disk, whole or not at all.

        `record_s` is the time spent recording this push up to here: the write of the row itself is not in it.

        Raises:
            OSError: no room for the row.
        """
        data, at = line(record, record_s).encode(), self._file.tell()
        try:
            if self._file.write(data) != len(data):  # the disk became full in the middle of it
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(self._file.fileno())
        except OSError:
            self._file.truncate(at)
            self._file.seek(at)
            raise

    def close(self) -> None:
        """Release the file."""
        self._file.close()


def line(record: PushRecord, record_s: float) -> str:
    """Format one row, in the order of `COLUMNS`."""
    return ",".join(_cell(value) for value in cells(record, record_s).values()) + "\n"


def cells(record: PushRecord, record_s: float) -> dict[str, Any]:
    """Values of one row by column name, in the order of `COLUMNS`; None where there is no action."""
    values: dict[str, Any] = dict.fromkeys(COLUMNS)
    for name in COLUMNS:
        if hasattr(record, name):
            values[name] = getattr(record, name)
    if (decision := record.decision) is not None:
        for name in ("phase", "kappa", "d", "speed", "acq", "xi_mean", "xi_std"):
            values[name] = getattr(decision, name)
        (values["kappa_min"], values["kappa_max"]), (values["d_min"], values["d_max"]) = decision.bounds
    if record.strain is not None:
        values |= {column: getattr(record.strain, name) for column, name in STRAIN.items()}
        values["limit_exceeded"] = record.strain.exceeded
    values["record_s"] = record_s
    return values


def _cell(value: Any) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    if isinstance(value, int):
        return str(int(value))  # true is 1
    return "" if math.isnan(value) else repr(float(value))


def read(path: Path) -> "pd.DataFrame":
    """Read a pushes.csv as a frame: `columns` of it side by side; errors as there."""
    import pandas as pd

    return pd.DataFrame(columns(path))


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Read a pushes.csv, one dictionary per row; an older table's rows lack what it lacks."""
    found = columns(path, all_columns=False)
    return [dict(zip(found, row, strict=True)) for row in zip(*found.values(), strict=True)]


def missing(name: str) -> str | float:
    """What an empty cell of this column is read as."""
    return "" if name in WORDS else math.nan


def columns(path: Path, all_columns: bool = True) -> dict[str, Column]:
    """Read a pushes.csv, also of a run that was killed: a last row that was cut is left out.

    Args:
        path: the file.
        all_columns: also those that an older table lacks, its strain, as nan.

    Returns:
        The columns `COLUMNS`, one value per k; `phase` is "" and the other action cells are nan in row 0.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not a table of pushes.
    """
    text = path.read_bytes().decode(errors="replace")
    rows = list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))
    known = rows and rows[0] in (COLUMNS, COLUMNS[:WITHOUT_STRAIN])
    if not known or any(len(row) != len(rows[0]) for row in rows):
        raise ValueError(f"{path}: not a table of pushes (its first line must name {', '.join(COLUMNS)})")
    names = COLUMNS if all_columns else rows[0]
    full = [[*row, *[""] * (len(names) - len(row))] for row in rows[1:]]
    cells = zip(*full, strict=True) if full else [()] * len(names)
    return {name: _column(name, part) for name, part in zip(names, cells, strict=True)}


def _column(name: str, cells: tuple[str, ...]) -> Column:
    # Python's own conversions are exact in both directions; pandas' parsers differ between versions.
    if name in WORDS:
        return list(cells)
    if name in WHOLE_NUMBERS:
        return [int(cell) for cell in cells]
    return [float(cell or "nan") for cell in cells]
