"""What the files of a run keep of its pushes: enough to go on from one of them without making it again."""

from dataclasses import dataclass

import numpy as np

from deformpush.cell.observation import Observation, View
from deformpush.cell.push import ToolPath
from deformpush.cell.world import Outcome, Strain
from deformpush.push_record import Action, PushRecord, Timing
from deformpush.record import poses as outlines
from deformpush.record import world_states
from deformpush.record.folder import RunFolder
from deformpush.record.poses import Poses
from deformpush.record.states import State, state_of
from deformpush.record.table import FORCE, STRAIN
from deformpush.record.unfinished import UnfinishedRun
from deformpush.record.world_states import WorldState
from deformpush.task import ERROR_COLUMNS, Errors

NOTHING = np.empty((0, 0), bool)
NO_PICTURE = np.empty((0, 0, 3), np.uint8)


@dataclass(frozen=True)
class Kept:
    """A state of the world after a push, and outlines and pictures of all pushes up to it."""

    run: UnfinishedRun
    world: WorldState
    poses: Poses
    pictures: list[bytes]

    @property
    def before(self) -> Observation | None:
        """What was seen one push before that state; None for the state before any push."""
        return self.seen(self.world.k - 1) if self.world.k else None

    def seen(self, k: int) -> Observation:
        """What was seen after push k, but for the mask."""
        poses = self.poses
        return Observation(poses.contours[k], poses.centroids[k], float(poses.thetas[k]), NOTHING, False)

    def state(self, k: int) -> State:
        """What states.bin holds of push k."""
        return state_of(self.record(k), self.pictures[k])

    def record(self, k: int) -> PushRecord:
        """Push k without picture, mesh, motion and maps, and what else no file tells."""
        row = self.run.rows[k]
        errors = Errors({column: row[column] for column in ERROR_COLUMNS})
        view = View(NO_PICTURE, self.seen(k))
        return PushRecord(k, view, errors, Timing(row["render_s"], row["decide_s"]), self._action(k))

    def _action(self, k: int) -> Action | None:
        if not k:
            return None
        row, made = self.run.rows[k], self.run.proposal(k)
        start, way = self.poses.starts[k], self.poses.ends[k] - self.poses.starts[k]
        length = float(np.linalg.norm(way))
        path = ToolPath(start, way / length, length - row["d"], row["d"], made.speed)
        told = {name: row.get(column, np.nan) for column, name in STRAIN.items()}
        strain = None if np.isnan(told["p99_peak"]) else Strain(**told)
        outcome = Outcome(row["steps"], row["step_s"], strain=strain)
        for name in FORCE:
            value = row.get(name, np.nan)
            setattr(outcome, name, None if np.isnan(value) else value)
        return Action(made, made.u, path, outcome, row["xi"])


def read(run: UnfinishedRun, most: int) -> Kept:
    """What is kept of a run up to push `most`, or up to the last one before it that can be gone on from.

    Raises:
        OSError: a file is missing or cannot be read.
        ValueError: a file is damaged from its beginning; the message is one line.
    """
    folder: RunFolder = run.folder
    poses, pictures = outlines.read_poses(folder.contours), outlines.read_pictures(folder.views)
    most = min(most, run.pushes, len(poses.contours) - 1, len(pictures) - 1)
    if (world := world_states.newest(folder.world_states, most)) is None:
        raise ValueError(f"{folder.world_states}: damaged, or not written by a run")
    return Kept(run, world, poses, pictures)
