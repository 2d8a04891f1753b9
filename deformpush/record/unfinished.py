"""A run as far as it came: what `resume` and `replay` take up."""

import math
from dataclasses import dataclass

import numpy as np

from deformpush.push_record import PushRecord
from deformpush.record import checkpoint, table
from deformpush.record.checkpoint import Checkpoint
from deformpush.record.folder import RunFolder
from deformpush.record.table import Cell, Row
from deformpush.state import Proposal

THOUGHTS = ("phase", "acq", "xi_mean", "xi_std", "kappa_min", "kappa_max", "d_min", "d_max")
"""Columns that the optimizer's thinking fills, not the world."""


@dataclass(frozen=True)
class UnfinishedRun:
    """The rows of pushes.csv, which alone decide how far a run came, and the newest usable checkpoint."""

    folder: RunFolder
    rows: list[Row]
    """Row 0 first; none if the run ended before its first row was written."""
    checkpoint: Checkpoint | None

    @property
    def pushes(self) -> int:
        """K, the pushes made."""
        return max(0, len(self.rows) - 1)

    @property
    def current(self) -> bool:
        """Whether the table has the columns of this version, so that rows can be added to it."""
        return not self.rows or list(self.rows[0]) == table.COLUMNS

    def proposal(self, k: int) -> Proposal:
        """The push of row k >= 1 as it was made, with as much of its reasons as the table tells."""
        row = self.rows[k]
        speed = row.get("speed", math.nan)
        return Proposal(
            u=np.array([row["kappa"], row["d"]]),
            phase=row["phase"],
            bounds=np.array([[row["kappa_min"], row["kappa_max"]], [row["d_min"], row["d_max"]]]),
            acq=row["acq"],
            mean=row["xi_mean"],
            std=row["xi_std"],
            speed=None if math.isnan(speed) else speed,
        )


def read(folder: RunFolder) -> UnfinishedRun:
    """Read what a run left.

    Raises:
        OSError: the table is there but cannot be read.
        ValueError: it is not a table of pushes, or its rows are not those of one run.
    """
    try:
        rows = table.read_rows(folder.table)
    except FileNotFoundError:
        rows = []
    for k, row in enumerate(rows):
        if row["k"] != k:
            raise ValueError(f"{folder.table}: row {k} says k = {row['k']}")
        if k and not all(math.isfinite(row[name]) for name in ("kappa", "d", "e_T")):
            raise ValueError(f"{folder.table}: row {k} names no push")
    found = checkpoint.read(folder.checkpoint)
    return UnfinishedRun(folder, rows, found if found is not None and 0 < found.k < len(rows) else None)


@dataclass(frozen=True)
class Difference:
    """A cell of a row that a push made again does not repeat."""

    name: str
    now: Cell
    then: Cell

    def __str__(self) -> str:
        """In words, with every digit."""
        return f"{self.name} is {self.now!r} and was {self.then!r}"

    @property
    def size(self) -> float:
        """How far apart two numbers are, in the column's unit; infinite where one is none."""
        if isinstance(self.now, int | float) and isinstance(self.then, int | float):
            return abs(self.now - self.then) if math.isfinite(self.now - self.then) else math.inf
        return math.inf


def differences(row: Row, record: PushRecord) -> list[Difference]:
    """What a push made again does otherwise than its row says, bit for bit.

    Times are never compared, nor what the optimizer thought, nor what another version's table lacks.
    """
    found = []
    for name, now in table.cells(record, 0.0).items():
        if name in (*table.TIMES, *THOUGHTS) or name not in row:
            continue
        then = row[name]
        now = table.missing(name) if now is None else now
        if now != then and not (now != now and then != then):
            found.append(Difference(name, now, then))
    return found
