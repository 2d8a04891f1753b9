"""One run: Algorithm 1 (initial samples), then Algorithm 2 (model, acquisition, push), to the goal.

Both ask, push, look and tell. They differ in where the push comes from, and that is the optimizer's business:
first the S0 pushes of its design, then those that its model chooses.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from deformpush.cell.cell import Cell
from deformpush.cell.observation import Observation, View
from deformpush.cell.perception import PerceptionError
from deformpush.cell.push import ToolPath
from deformpush.cell.variation import Draw
from deformpush.cell.world import Outcome, WorldError
from deformpush.optimizer.base import Optimizer
from deformpush.push_record import EFFECTIVE_POINTS, Action, Ending, PushRecord, Timing
from deformpush.state import Proposal, State
from deformpush.task import Errors, Task

Array = np.ndarray


@dataclass(eq=False)
class Episode:
    """One run between two pushes: what the world, the task and the optimizer have come to."""

    cell: Cell
    task: Task
    optimizer: Optimizer
    max_pushes: int
    draw: Draw

    def __post_init__(self) -> None:
        """Look at the object and fix the goal.

        Raises:
            PerceptionError: the object cannot be seen.
            UserError: the goal is no goal.
        """
        view, render_s = self.cell.look(None)
        self.target = self.task.target(view.seen, self.cell.perception.mask, self.draw)
        errors = self.task.errors(view.seen, self.target)
        self._e_T_start = errors.e_T
        self.record = PushRecord(0, view, errors, Timing(render_s=render_s))
        """The newest; row 0 is the state before any push."""
        self.state = self._know(view, errors)
        """What the optimizer may know of it."""
        self.wanted: Array | None = None
        """The push (kappa, d) that the optimizer chose last, as the robot could reach it."""
        self.optimizer.attach(self)

    def push(self, maps: bool = False, u: Array | None = None, speed: float | None = None) -> PushRecord:
        """One turn of the while loop of Algorithm 2: ask, push, look, tell.

        Args:
            maps: whether the record shall hold what the optimizer believes of all pushes.
            u: the push to make, whatever the optimizer wants; it is asked and told all the same.
            speed: how fast to make `u` (m/s); None: as the world is set.

        Raises:
            WorldError: the push cannot be made.
            PerceptionError: the object cannot be seen any more.
        """
        before = self.state
        began = perf_counter()
        proposal = self.optimizer.ask(before).reported()  # lines 8 and 9: constAdaption, acquisition
        decide_s = perf_counter() - began
        pictures = self.optimizer.maps() if maps else {}
        self.wanted, path = self.cell.reachable(proposal.u, before.seen)
        if u is None:
            u, path = self.wanted, replace(path, speed=proposal.speed)
        else:
            path = replace(self.cell.plan(u, before.seen), speed=speed)
        record = self._apply(proposal, u, path, pictures)  # lines 10 and 12 to 15
        began = perf_counter()
        assert record.action is not None
        self.optimizer.tell(u, record.action.xi, before, self.state)  # line 11: updateModel
        decide_s += perf_counter() - began
        self.record = replace(record, timing=replace(record.timing, decide_s=decide_s))
        return self.record

    def repeat(self, proposal: Proposal) -> PushRecord:
        """Make a push that is known to have been made, without the optimizer; errors as in `push`."""
        path = self.cell.plan(proposal.u, self.state.seen)
        self.record = self._apply(proposal, proposal.u, replace(path, speed=proposal.speed), {})
        return self.record

    def take_up(self, k: int, state: bytes, before: Observation | None, sim_time_s: float) -> None:
        """Go to where push k once led: the world to `state`, the object last seen at `before`.

        Raises:
            ValueError: it is no state of this world.
            PerceptionError: the object cannot be seen.
        """
        self.cell.world.restore(state)
        seen = None if before is None else replace(before, first=self.state.seen.first)
        view, render_s = self.cell.look(seen)
        errors = self.task.errors(view.seen, self.target)
        self.state = self._know(view, errors)
        self.record = PushRecord(k, view, errors, Timing(render_s, 0.0, sim_time_s))

    def e_T_after(self, U: Array) -> Array:
        """e_T `(n,)` after each of pushes U `(n, 2)`, tried in copies of the world; nan where one fails."""
        looks = self.cell.seen_after(U, self.state.seen)
        return np.array([np.nan if x is None else self.task.errors(x, self.target).e_T for x in looks])

    @property
    def ending(self) -> Ending | None:
        """How the run ended; None while there is more to do."""
        return Ending.of(self.record, self.task, self.max_pushes)

    def _apply(self, proposal: Proposal, u: Array, path: ToolPath, maps: dict[str, Array]) -> PushRecord:
        """applyPushingAction: push, look, and work out the errors."""
        before, effective = self.record, self.state.effective.places(EFFECTIVE_POINTS)
        outcome = self.cell.world.push(path)
        view, render_s = self.cell.look(before.view.seen)
        errors = self.task.errors(view.seen, self.target)
        self.state = self._know(view, errors, outcome, path.speed)
        action = Action(proposal, u, path, outcome, errors.e_T - before.errors.e_T, effective, maps)
        timing = Timing(render_s, 0.0, before.timing.sim_time_s + outcome.sim_s)
        return PushRecord(before.k + 1, view, errors, timing, action)

    def _know(
        self, view: View, errors: Errors, outcome: Outcome | None = None, speed: float | None = None
    ) -> State:
        """What the optimizer may know after a look; `outcome` and `speed` are those of the push before."""
        cell, share = self.cell, errors.e_T / self._e_T_start
        state = State(view.seen, self.target, errors, share, self.task.weights, cell.layout, cell.part, speed)
        if outcome is not None and outcome.strain is not None:
            state = replace(state, strain=outcome.strain.p99_peak)
        if "film" in self.optimizer.needs:
            now, film = cell.outlines([view.nodes]), [] if outcome is None else outcome.film
            state = replace(state, pressed=cell.outlines(film), at_rest=now[0] if now else None)
        return state


def run(episode: Episode, maps: bool, listeners: Sequence[Callable[[PushRecord], object]]) -> Ending:
    """Push until the stop rule holds, the budget is spent or a push fails; listeners hear every record."""
    try:
        while episode.ending is None:
            record = episode.push(maps)
            for listener in listeners:
                listener(record)
    except (WorldError, PerceptionError) as problem:
        return Ending("failed", str(problem))
    return episode.ending
