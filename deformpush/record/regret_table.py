"""regret.csv and regret_trials.csv: what the pushes of a run gained beside what others would have gained."""

from collections.abc import Sequence
from pathlib import Path

from deformpush.record.files import TABLE_BYTES, append, read_bytes, to_append, write_whole
from deformpush.record.table import Column, as_line, column, read_csv

REGRET, TRIALS = "regret.csv", "regret_trials.csv"
PUSHES = 48
"""So many are tried from each state, unless said otherwise."""
COLUMNS = (
    *("k", "phase", "kappa", "d", "e_T_before", "xi"),
    *("xi_best", "kappa_best", "d_best", "regret", "cumulative_regret", "rank"),
    *("trials", "failed", "xi_tried"),
    *("xi_mean", "xi_std", "best_mean", "best_std"),
    *("inference_regret", "inside_95", "z_mean", "z_rms", "rmse", "kendall_tau"),
)
"""Of regret.csv, a row for each push."""
TRIAL_COLUMNS = ("k", "kappa", "d", "xi", "xi_mean", "xi_std")
"""Of regret_trials.csv, a row for each push that was tried."""
TEXTS, WHOLE_NUMBERS = ("phase",), ("k", "rank", "trials", "failed")

Number = int | float
Numbers = dict[str, Number]
Row = dict[str, str | Number]
Columns = dict[str, Column]


class RegretTable:
    """Both files, a push after the other; the row of regret.csv is written last."""

    def __init__(self, folder: Path, trials: int, anew: bool = False) -> None:
        """Read which pushes both files have whole; nothing is written before `open`.

        Args:
            folder: where they are.
            trials: pushes tried from each state.
            anew: whether to begin again, whatever is there.

        Raises:
            OSError: a file cannot be read.
            ValueError: one is no such table, or holds another number of trials.
        """
        self._paths, self._trials = (folder / REGRET, folder / TRIALS), trials
        self.rows: list[Row] = []
        """Those of regret.csv that stay."""
        there = [path for path in self._paths if path.exists()]
        if not there or anew:
            return
        if len(there) == 1:
            raise ValueError(f"{folder}: holds {there[0].name} without the file that belongs to it")
        found, k, whole = read(there[0]), read_trials(there[1])["k"], 0
        rows = [dict(zip(found, row, strict=True)) for row in zip(*found.values(), strict=True)]
        if others := {row["trials"] for row in rows} - {trials}:
            raise ValueError(f"{there[0]}: holds {others.pop()} trials a push, not {trials}")
        while k[whole * trials : (whole + 1) * trials] == [whole + 1] * trials:
            whole += 1
        self.rows = [row for n, row in enumerate(rows, start=1) if row["k"] == n <= whole]

    def open(self) -> None:
        """Begin the files, or cut off what is behind the pushes that they have whole.

        Raises:
            OSError: a file cannot be written.
        """
        done = len(self.rows)
        for path, names, lines in zip(
            self._paths, (COLUMNS, TRIAL_COLUMNS), (done, done * self._trials), strict=True
        ):
            kept = read_bytes(path, TABLE_BYTES).splitlines(keepends=True)[1 : lines + 1] if done else []
            write_whole(path, b"".join([as_line(names).encode(), *kept]))
        self._files = [to_append(path) for path in self._paths]

    def append(self, row: Row, trials: Sequence[Row]) -> None:
        """Bring a push to the disk: its trials, then its row, each whole or not at all.

        Raises:
            OSError: no room.
        """
        regret, others = self._files
        append(
            others,
            "".join(as_line(one[name] for name in TRIAL_COLUMNS) for one in trials).encode(),
            sync=False,
        )
        append(regret, as_line(row[name] for name in COLUMNS).encode(), sync=True)
        self.rows.append(row)

    def close(self) -> None:
        """Release the files."""
        for file in self._files:
            file.close()


def read(path: Path) -> Columns:
    """Read a regret.csv, also of a walk that was stopped; an empty cell is nan.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not a table of regret.
    """
    return _read(path, COLUMNS, "regret")


def read_trials(path: Path) -> Columns:
    """Read a regret_trials.csv, in the same way."""
    return _read(path, TRIAL_COLUMNS, "trials")


def _read(path: Path, names: Sequence[str], what: str) -> Columns:
    header, rows = read_csv(path, what)
    if header != list(names):
        raise ValueError(f"{path}: not a table of {what} (its first line must name {', '.join(names)})")
    parts = zip(*rows, strict=True) if rows else [()] * len(names)
    try:
        return {
            name: column(part, name in TEXTS, name in WHOLE_NUMBERS)
            for name, part in zip(names, parts, strict=True)
        }
    except ValueError as error:
        raise ValueError(f"{path}: not a table of {what} ({error})") from error
