"""forecasts.csv: where each push was expected to bring the object, and where it came to lie."""

from pathlib import Path
from typing import BinaryIO

import numpy as np

from deformpush.push_record import PushRecord
from deformpush.record.files import TABLE_BYTES, append, read_bytes, to_append, write_whole
from deformpush.record.table import read_csv

OUTCOMES = ("x_m", "y_m", "theta_rad", "e_gamma")
COLUMNS = ("k", *(f"{name}{part}" for name in OUTCOMES for part in ("_mean", "_std", "")))
INSIDE = 1.96
"""Standard deviations within which 95 % of a normal variable lie."""


class Forecasts:
    """Appends one row per push that was forecast; without any there is no file."""

    def __init__(self, path: Path) -> None:
        """Nothing is written before the first forecast."""
        self._path = path
        self._file: BinaryIO | None = None
        self._inside = self._all = 0

    @classmethod
    def reopen(cls, path: Path, pushes: int) -> "Forecasts":
        """Go on with a file after those of the first `pushes` pushes; a damaged one is begun anew."""
        forecasts = cls(path)
        try:
            k, mean, std, came = read(path)
        except (OSError, ValueError):
            path.unlink(missing_ok=True)
            return forecasts
        kept = k <= pushes
        lines = read_bytes(path, TABLE_BYTES).splitlines(keepends=True)[: 1 + int(kept.sum())]
        write_whole(path, b"".join(lines))
        forecasts._file = to_append(path)
        forecasts._count((np.abs(came - mean) <= INSIDE * std)[kept])
        return forecasts

    def append(self, record: PushRecord) -> None:
        """Append the forecast of push k and what came, if there was one, and bring it to the disk."""
        forecast = None if record.action is None else record.action.proposal.forecast
        if forecast is None:
            return
        if self._file is None:
            write_whole(self._path, (",".join(COLUMNS) + "\n").encode())
            self._file = to_append(self._path)
        mean, std = forecast.mean, np.sqrt(np.diag(forecast.cov))
        came = actual(record)
        self._count(np.abs(came - mean) <= INSIDE * std)
        cells = np.stack([mean, std, came], axis=1).ravel().tolist()
        append(self._file, (",".join([str(record.k), *map(repr, cells)]) + "\n").encode(), sync=True)

    @property
    def calibration(self) -> float | None:
        """Share of outcomes inside their 95 % intervals; None without a forecast."""
        return self._inside / self._all if self._all else None

    def close(self) -> None:
        """Release the file."""
        if self._file is not None:
            self._file.close()

    def _count(self, inside: np.ndarray) -> None:
        """Count outcomes, and those inside their intervals."""
        self._inside += int(inside.sum())
        self._all += inside.size


def actual(record: PushRecord) -> np.ndarray:
    """Centroid (m), angle (rad), shape error (3) `(4,)` after the push, in the order of `OUTCOMES`."""
    seen = record.view.seen
    return np.array([*seen.c, seen.theta, record.errors[OUTCOMES[-1]]])


def read(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Read a forecasts.csv, also of a run that was killed.

    Returns:
        k `(n,)`; means, standard deviations and what came, each `(n, 4)` in the order of `OUTCOMES`.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not a table of forecasts.
    """
    header, rows = read_csv(path, "forecasts")
    if tuple(header) != COLUMNS:
        raise ValueError(f"{path}: not a table of forecasts (its first line must name {', '.join(COLUMNS)})")
    cells = np.array(rows, float).reshape(-1, len(COLUMNS))
    mean, std, came = cells[:, 1:].reshape(-1, len(OUTCOMES), 3).transpose(2, 0, 1)
    return cells[:, 0].astype(int), mean, std, came
