"""What the pictures of one run are made of, read from its folder."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from deformpush.record import table
from deformpush.record.folder import RunFolder
from deformpush.record.poses import Poses, read_poses, read_views

if TYPE_CHECKING:
    import pandas as pd

Array = np.ndarray


@dataclass(frozen=True)
class RunData:
    """A run's table, poses and pictures, as far as each of them reaches."""

    pushes: "pd.DataFrame"
    """pushes.csv, a row for each k."""
    poses: Poses
    pictures: Sequence[Array]
    """RGB `(H, W, 3)` for each k."""

    @property
    def last(self) -> int:
        """The last k that table, poses and pictures all have."""
        return min(len(self.pushes), len(self.poses.contours), len(self.pictures)) - 1

    @property
    def initial(self) -> int:
        """Pushes of the initial design, S0 or as many as were made."""
        return int((self.pushes["phase"] == "initial").sum())

    @property
    def moments(self) -> list[int]:
        """Four k worth a picture: 0, S0, half-way from there, the last.

        Evenly spaced ones where nothing follows the initial design, or there is none.
        """
        if not 0 < self.initial < self.last:
            return [round(self.last * share / 3) for share in range(4)]
        return [0, self.initial, (self.initial + self.last) // 2, self.last]


def read(folder: RunFolder) -> RunData:
    """Read a run folder, also one of a run that was killed.

    Raises:
        OSError, ValueError: a file is missing or damaged.
    """
    return RunData(table.read(folder.table), read_poses(folder.contours), read_views(folder.views))
