"""One run: Algorithm 1 (initial samples), then Algorithm 2 (model, acquisition, push), to the goal."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from deformpush.cell import Cell, know, look, nearest_reachable
from deformpush.contour import Observation, PerceptionError
from deformpush.errors import UserError
from deformpush.optimizer.protocol import Proposal
from deformpush.push import ToolPath
from deformpush.record.push_record import Decision, PushRecord, RunInfo, View
from deformpush.record.recorder import Recorder
from deformpush.record.summary import Summary
from deformpush.sim.world import Outcome, SimulationError
from deformpush.task import Errors, Target

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


def run(
    cell: Cell,
    begin: Start,
    recorder: Recorder,
    info: RunInfo,
    watch: Callable[[PushRecord], None] = lambda record: None,
) -> Summary:
    """Push until the stop rule holds or the budget is spent.

    Args:
        cell: the robot cell.
        begin: the state before any push, from `start`.
        recorder: writes what happens; the loop does not depend on it.
        info: what the recorder is told about the run.
        watch: called after every record, for a progress bar.

    Raises:
        KeyboardInterrupt: Ctrl-C; the recorder has closed the run as `failed`.
    """
    task, optimizer, seen, target = cell.task, cell.optimizer, begin.seen, begin.target
    errors = task.errors(seen, target)
    at_start = errors.e_T

    with recorder:
        state = know(cell, seen, target, errors, at_start)
        record = PushRecord(k=0, after=begin.view, render_s=begin.render_s, **vars(errors))
        recorder.open(info, record)
        watch(record)
        k, sim_time = 0, 0.0
        try:
            while not task.reached(errors) and k < cell.max_pushes:
                began = perf_counter()
                proposal = optimizer.ask(state)
                decide_s = perf_counter() - began
                maps = optimizer.maps() if recorder.maps else {}

                u, path = nearest_reachable(cell, proposal.u, seen)
                outcome = cell.world.push(path)
                seen, view, render_s = look(cell, seen)
                before, errors = errors, task.errors(seen, target)

                began = perf_counter()
                xi = errors.e_T - before.e_T
                left, state = state, know(cell, seen, target, errors, at_start, outcome.strain)
                optimizer.tell(u, xi, left, state)
                decide_s += perf_counter() - began
                k, sim_time = k + 1, sim_time + outcome.sim_s

                decision = _decision(proposal, u, path, left.effective, maps)
                record = _record(k, view, errors, decision, xi, outcome, render_s, decide_s, sim_time)
                recorder.push(record)
                watch(record)
        except (SimulationError, PerceptionError) as problem:
            return recorder.close("failed", str(problem))
        if task.reached(errors):
            return recorder.close("reached", f"{task.stop_when} errors at or under their stop values")
        return recorder.close("budget", f"the budget of {cell.max_pushes} pushes is spent")


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


def _record(
    k: int,
    view: View,
    errors: Errors,
    decision: Decision,
    xi: float,
    outcome: Outcome,
    render_s: float,
    decide_s: float,
    sim_time: float,
) -> PushRecord:
    times: dict[str, Any] = {"step_s": outcome.step_s, "render_s": render_s, "decide_s": decide_s}
    return PushRecord(
        k=k,
        after=view,
        decision=decision,
        xi=xi,
        steps=outcome.steps,
        sim_time_s=sim_time,
        motion=tuple(outcome.motion),
        strain=outcome.strain,
        **times,
        **vars(errors),
    )
