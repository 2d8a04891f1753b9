"""A run before one of its pushes, where another one can be made instead."""

from contextlib import ExitStack

import numpy as np

from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import WorldError
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.assemble import begin
from deformpush.experiment.one_thread import one_thread
from deformpush.experiment.repeat import DivergedError, hear
from deformpush.experiment.run import put_up, read_unfinished, reload
from deformpush.experiment.setup import Setup
from deformpush.experiment.take_up import go_before
from deformpush.loop import Episode
from deformpush.push_record import PushRecord
from deformpush.record.folder import RunFolder
from deformpush.record.kept import Kept
from deformpush.state import Proposal

Array = np.ndarray

PHASE = "what if"
"""Of a push that no optimizer chose."""


class Branch:
    """A run before push k, in a world of its own: what is pushed here leaves the run as it was."""

    def __init__(self, folder: RunFolder, push: int) -> None:
        """Go to the state before a push of a run, and make the push again to be sure that it is that state.

        Raises:
            UserError: there is no such push, or no state of the world before it was saved.
            DivergedError: the push does not end as it was recorded.
        """
        self.setup: Setup = reload(folder)
        self.run = read_unfinished(folder)
        if not 1 <= push <= self.run.pushes:
            raise UserError(f"push = {push}: must be 1 to {self.run.pushes}, the pushes of {folder.path}")
        optimizer, cell = put_up(self.setup, folder)
        with ExitStack() as failed, one_thread():
            failed.callback(cell.world.close)
            self.episode: Episode = begin(self.setup, cell, optimizer)
            """Where the last push led."""
            self.first: PushRecord = self.episode.record
            """Row 0."""
            self.kept: Kept = go_before(self.episode, self.run, push)
            """What the run's files keep of it up to the state before the push."""
            self.before: PushRecord = self.episode.record
            """The state before the push: row k - 1."""
            try:
                self.made: PushRecord = self.episode.repeat(self.run.proposal(push))
                """The push as the run made it."""
            except (WorldError, PerceptionError) as problem:
                raise DivergedError(self.run, push, str(problem)) from problem
            hear(self.run, self.made)
            failed.pop_all()

    @property
    def k(self) -> int:
        """Which push another one stands for here."""
        return self.before.k + 1

    def push(self, kappa: float, d: float, speed: float | None = None) -> PushRecord:
        """Make another push k, as often as you like: each begins in the same state.

        Args:
            kappa: where along the effective contour (0 to 1).
            d: how far (m).
            speed: of the tool (m/s); None: as the world is set.

        Raises:
            UserError: it is no push of this run's bounds.
            TroubleError: it cannot be made: out of the robot's reach, or the object is not seen any more.
        """
        bounds = self.setup.bounds.outer
        for name, value, (low, high) in zip(("kappa", "d"), (kappa, d), bounds.tolist(), strict=True):
            if not low <= value <= high:
                raise UserError(f"{name} = {value:g}: must be {low:g} to {high:g}, as bounds.{name} says")
        if speed is not None and not 0 < speed < np.inf:
            raise UserError(f"speed = {speed:g}: must be more than 0")
        with one_thread():
            self._return()
            try:
                return self.episode.repeat(Proposal(np.array([kappa, d], float), PHASE, bounds, speed=speed))
            except (WorldError, PerceptionError) as problem:
                raise TroubleError(f"the other push cannot be made: {problem}") from problem

    def e_T_after(self, U: Array) -> Array:
        """e_T `(n,)` after each of pushes U `(n, 2)` made as push k, on all cores; nan where one fails."""
        with one_thread():
            self._return()
            return self.episode.e_T_after(U)

    def close(self) -> None:
        """Free what the world holds."""
        self.episode.cell.world.close()

    def __enter__(self) -> "Branch":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _return(self) -> None:
        """Go to the state before the push again."""
        world = self.kept.world
        self.episode.take_up(world.k, world.state, self.kept.before, world.sim_time_s)
