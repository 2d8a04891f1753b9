"""One run: Algorithm 1 (initial samples), then Algorithm 2 (model, acquisition, push), until the goal is reached."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from deformpush.camera import Camera
from deformpush.contour import Observation, Perception, PerceptionError
from deformpush.errors import UserError
from deformpush.optimizer.protocol import Optimizer, Proposal
from deformpush.push import EffectiveContour, Push, ToolPath
from deformpush.record.push_record import Decision, PushRecord, RunInfo, View
from deformpush.record.recorder import Recorder
from deformpush.record.summary import Summary
from deformpush.sim.world import Outcome, SimulationError, World
from deformpush.task import Draw, Errors, Target, Task

Array = np.ndarray


@dataclass(frozen=True)
class Cell:
    """A robot cell: everything the loop works with."""

    world: World
    camera: Camera
    perception: Perception
    push: Push
    part: EffectiveContour
    task: Task
    draw: Draw
    optimizer: Optimizer
    max_pushes: int


@dataclass(frozen=True)
class State:
    """What an optimizer may know of the object before it answers (see `optimizer.protocol.State`)."""

    contour: Array
    c: Array
    theta: float
    effective: Array
    goal_c: Array
    goal_theta: float
    e_T_share: float
    """e_T over the e_T at the stop values."""


def run(
    cell: Cell,
    recorder: Recorder,
    describe: Callable[[Target], RunInfo],
    watch: Callable[[PushRecord], None] = lambda record: None,
) -> Summary:
    """Push until every stop value is reached or the budget is spent.

    Args:
        cell: the robot cell.
        recorder: writes what happens; the loop does not depend on it.
        describe: tells the recorder about the run once the goal is known.
        watch: called after every record, for a progress bar.

    Raises:
        UserError: the goal cannot be seen or reached; nothing has been pushed or recorded.
        KeyboardInterrupt: Ctrl-C; the recorder has closed the run as `failed`.
    """
    task, optimizer = cell.task, cell.optimizer
    seen, view, render_s = look(cell, None)
    target = task.target(seen, cell.perception.mask, cell.draw)
    check_goal(cell, target)
    errors, done = task.errors(seen, target), task.e_T_when_done(target)

    with recorder:
        record = PushRecord(k=0, after=view, render_s=render_s, **vars(errors))
        recorder.open(describe(target), record)
        watch(record)
        sim_time, k = 0.0, 0
        try:
            while not task.reached(errors) and k < cell.max_pushes:
                began = perf_counter()
                effective = cell.push.effective(seen, cell.part)
                state = State(seen.contour, seen.c, seen.theta, effective, target.c, target.theta, errors.e_T / done)
                proposal = optimizer.ask(state)
                decide_s = perf_counter() - began
                maps = optimizer.maps() if recorder.maps else {}

                path = cell.push.plan(proposal.u, seen, cell.part)
                outcome = cell.world.push(path)
                seen, view, render_s = look(cell, seen)
                before, errors = errors, task.errors(seen, target)

                began = perf_counter()
                xi = errors.e_T - before.e_T
                optimizer.tell(proposal.u, xi, state)
                decide_s += perf_counter() - began
                k, sim_time = k + 1, sim_time + outcome.sim_s

                decision = _decision(proposal, path, effective, maps)
                record = _record(k, view, errors, decision, xi, outcome, render_s, decide_s, sim_time)
                recorder.push(record)
                watch(record)
        except (SimulationError, PerceptionError) as problem:
            return recorder.close("failed", str(problem))
        if task.reached(errors):
            return recorder.close("reached", f"{task.stop_when} errors at or under their stop values")
        return recorder.close("budget", f"the budget of {cell.max_pushes} pushes is spent")


def look(cell: Cell, previous: Observation | None) -> tuple[Observation, View, float]:
    """Take a picture and make out the object in it; also the seconds this took."""
    began = perf_counter()
    image = cell.world.image()
    seen = cell.perception.observe(image, cell.camera, previous)
    seconds = perf_counter() - began
    return seen, View(image, seen.contour, seen.c, seen.theta, cell.world.nodes(), cell.world.joints()), seconds


def check_goal(cell: Cell, target: Target) -> None:
    """Refuse a goal that the camera cannot see or the tool cannot reach.

    Raises:
        UserError: names `task.goal.offset` and where the goal lies.
    """
    where = f"task.goal.offset = {list(cell.task.goal.offset)}: the goal at ({target.c[0]:.3f}, {target.c[1]:.3f}) m"
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


def _decision(proposal: Proposal, path: ToolPath, effective: Array, maps: dict[str, Array]) -> Decision:
    return Decision(
        phase=proposal.phase,
        kappa=float(proposal.u[0]),
        d=float(proposal.u[1]),
        bounds=proposal.bounds,
        acq=proposal.acq,
        xi_mean=proposal.mean,
        xi_std=proposal.std,
        start=path.start,
        end=path.end,
        effective=effective,
        maps=maps,
        info=proposal.info,
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
        **times,
        **vars(errors),
    )
