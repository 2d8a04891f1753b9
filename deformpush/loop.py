"""One run: Algorithm 1 (initial samples), then Algorithm 2 (model, acquisition, push), to the goal."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from deformpush.cell.cell import Cell, know, look, nearest_reachable
from deformpush.cell.perception import Observation, PerceptionError
from deformpush.cell.push import ToolPath
from deformpush.cell.world import Outcome, SimulationError
from deformpush.errors import UserError
from deformpush.experiment.recorder import Recorder
from deformpush.optimizer.protocol import Proposal
from deformpush.push_record import Decision, PushRecord, Strain, View
from deformpush.record.summary import Status, Summary
from deformpush.task import Target

Array = np.ndarray


@dataclass(frozen=True)
class Start:
    """The state before any push, and the goal that follows from it."""

    seen: Observation
    view: View
    render_s: float
    target: Target


def start(cell: Cell) -> Start:
    """Look at the object and fix the goal.

    Raises:
        UserError: the object is not in the picture, nothing of it may be pushed, or the goal cannot be seen
            or reached.
    """
    try:
        seen, view, render_s = look(cell, None)
    except PerceptionError as problem:
        raise UserError(
            f"object.start: {problem}; camera.centre and camera.field say what it shows"
        ) from problem
    if len(cell.part.indices(seen)) < 2:
        raise UserError(
            f"object.effective.last_deg = {cell.part.last_deg:g}: gives an effective contour of zero length, "
            f"first_deg = {cell.part.first_deg:g} sees the same contour point; they must be further apart"
        )
    target = cell.task.target(seen, cell.perception.mask, cell.draw)
    check_goal(cell, target)
    return Start(seen, view, render_s, target)


class Episode:
    """One run between two pushes: what the world, the task and the optimizer have come to."""

    def __init__(self, cell: Cell, begin: Start) -> None:
        self.cell, self.target, self.k = cell, begin.target, 0
        self._seen, self._sim_time = begin.seen, 0.0
        self._errors = cell.task.errors(begin.seen, begin.target)
        self._at_start = self._errors.e_T
        self._state = know(cell, begin.seen, begin.target, self._errors, self._at_start)
        self.first = PushRecord(k=0, after=begin.view, render_s=begin.render_s, **vars(self._errors))
        """Row 0: the state before any push."""
        self.strain: Strain | None = None
        """That of the push before, where it is measured."""
        self.wanted: Array | None = None
        """The push (kappa, d) that the optimizer chose last, as the robot could reach it."""

    @property
    def reached(self) -> bool:
        """Whether the stop rule holds."""
        return self.cell.task.reached(self._errors)

    @property
    def damaged(self) -> bool:
        """Whether the push before did harm and that ends the run."""
        harmed = self.strain is not None and bool(self.strain.exceeded)
        return harmed and self.cell.task.stop.on_damage

    @property
    def over(self) -> bool:
        """Whether there is nothing more to do."""
        return self.damaged or self.reached or self.k >= self.cell.max_pushes

    def ending(self) -> tuple[Status, str]:
        """Status and reason, once it is over."""
        if self.damaged:
            assert self.strain is not None
            peak, limit = self.strain.p99_peak, self.strain.limit
            return "damaged", f"push {self.k} strained the object to {peak:.3g}, its limit is {limit:g}"
        if self.reached:
            return "reached", f"{self.cell.task.stop_when} errors at or under their stop values"
        return "budget", f"the budget of {self.cell.max_pushes} pushes is spent"

    def push(self, maps: bool = False, u: Array | None = None, speed: float | None = None) -> PushRecord:
        """Ask, push, look, tell.

        Args:
            maps: whether the record shall hold what the optimizer believed over all pushes.
            u: the push to make, whatever the optimizer wants; it is asked and told all the same.
            speed: how fast to make it (m/s; nan: as the world is set); None: as the optimizer wants.

        Raises:
            SimulationError: the push cannot be made.
            PerceptionError: the object cannot be seen any more.
        """
        cell, optimizer = self.cell, self.cell.optimizer
        began = perf_counter()
        proposal = optimizer.ask(self._state)
        decide_s = perf_counter() - began
        pictures = optimizer.maps() if maps else {}

        self.wanted, path = nearest_reachable(cell, proposal.u, self._seen)
        if u is not None:
            path = cell.push.plan(u, self._seen, cell.part)
        u = self.wanted if u is None else u
        speed = proposal.speed if speed is None else speed
        path = replace(path, speed=None if np.isnan(speed) else speed)
        left = self._state
        decision = _decision(proposal, u, path, left.effective, pictures)
        outcome, view, render_s, xi = self._move(path)

        began = perf_counter()
        optimizer.tell(u, xi, left, self._state)
        decide_s += perf_counter() - began
        return self._record(decision, view, outcome, render_s, decide_s, xi)

    def again(self, decision: Decision) -> PushRecord:
        """Make a push that is known to have been made, without the optimizer; errors as in `push`."""
        path = self.cell.push.plan(np.array([decision.kappa, decision.d]), self._seen, self.cell.part)
        path = replace(path, speed=None if np.isnan(decision.speed) else decision.speed)
        decision = replace(decision, start=path.start, end=path.end, effective=self._state.effective)
        outcome, view, render_s, xi = self._move(path)
        return self._record(decision, view, outcome, render_s, 0.0, xi)

    def _move(self, path: ToolPath) -> tuple[Outcome, View, float, float]:
        cell, before = self.cell, self._errors
        outcome = cell.world.push(path)
        self.strain = outcome.strain
        self._seen, view, render_s = look(cell, self._seen)
        self._errors = cell.task.errors(self._seen, self.target)
        self._state = know(cell, self._seen, self.target, self._errors, self._at_start, outcome, path.speed)
        self.k, self._sim_time = self.k + 1, self._sim_time + outcome.sim_s
        return outcome, view, render_s, self._errors.e_T - before.e_T

    def _record(
        self, decision: Decision, view: View, outcome: Outcome, render_s: float, decide_s: float, xi: float
    ) -> PushRecord:
        return PushRecord(
            k=self.k,
            after=view,
            decision=decision,
            xi=xi,
            steps=outcome.steps,
            step_s=outcome.step_s,
            render_s=render_s,
            decide_s=decide_s,
            sim_time_s=self._sim_time,
            motion=tuple(outcome.motion),
            strain=outcome.strain,
            **vars(self._errors),
        )


def run(
    episode: Episode,
    recorder: Recorder,
    begin: Callable[[], object],
    watch: Callable[[PushRecord], None] = lambda record: None,
) -> Summary:
    """Push until the stop rule holds or the budget is spent.

    Args:
        episode: where it starts.
        recorder: writes what happens; the loop does not depend on it.
        begin: opens the recorder, as a new run or as one that goes on.
        watch: called after every record, for a progress bar.

    Raises:
        KeyboardInterrupt: Ctrl-C; the recorder has closed the run as `interrupted`.
        OSError: what happens cannot be written any more; the run can be resumed.
    """
    cell = episode.cell
    with recorder:
        begin()
        try:
            while not episode.over:
                record = episode.push(recorder.maps)
                recorder.push(record, cell.optimizer.state())
                watch(record)
        except (SimulationError, PerceptionError) as problem:
            return recorder.close("failed", str(problem))
        return recorder.close(*episode.ending())


def check_goal(cell: Cell, target: Target) -> None:
    """Refuse a goal that the camera cannot see or the tool cannot reach.

    Raises:
        UserError: names `task.goal.offset` and where the goal lies.
    """
    x, y = target.c
    where = f"task.goal.offset = {list(cell.task.goal.offset)}: the goal at ({x:.3f}, {y:.3f}) m"
    if not cell.camera.sees(target.outline, cell.perception.border_px):
        half = cell.camera.field / 2
        low, high = np.array(cell.camera.centre) - half, np.array(cell.camera.centre) + half
        raise UserError(
            f"{where} is not wholly inside the picture, which shows x {low[0]:.2f} to {high[0]:.2f} m and "
            f"y {low[1]:.2f} to {high[1]:.2f} m"
        )
    around = np.vstack([target.outline, target.c])
    if not cell.world.can_reach(around).all():
        raise UserError(f"{where} has parts out of the robot's reach; move it nearer or use robot=tool")


def _decision(
    proposal: Proposal, u: Array, path: ToolPath, effective: Array, maps: dict[str, Array]
) -> Decision:
    return Decision(
        phase=proposal.phase,
        kappa=float(u[0]),
        d=float(u[1]),
        speed=float("nan") if path.speed is None else path.speed,
        bounds=proposal.bounds,
        acq=proposal.acq,
        xi_mean=proposal.mean,
        xi_std=proposal.std,
        start=path.start,
        end=path.end,
        effective=effective,
        maps=maps,
        info=proposal.info,
        forecast=proposal.forecast,
    )
