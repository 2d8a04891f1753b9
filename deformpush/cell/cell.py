"""A robot cell: what the loop works with, how it looks, and what it lets the optimizer know."""

import logging
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.perception import Observation, Perception
from deformpush.cell.push import EffectiveContour, Push, ToolPath
from deformpush.cell.silhouette import silhouette
from deformpush.cell.world import Outcome, SimulationError, World
from deformpush.optimizer.protocol import Optimizer
from deformpush.push_record import View
from deformpush.task import Draw, Errors, Target, Task, TotalError
from deformpush.worlds.fork import branched

Array = np.ndarray

log = logging.getLogger(__name__)


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
    """e_T over its value at the start."""
    e_gamma: float
    strain: float
    """Peak p99 strain of the push that led here (-); nan before any, and where it is not measured."""
    pressed: Callable[[], list[Array]]
    """Contours `(M, 2)` (m) during the push that led here, as the camera sees them picture by picture."""
    at_rest: Callable[[], list[Array]]
    """The contour now as `pressed` would show it; none where that shows none."""
    speed: float
    """Tool speed of that push (m/s); nan where the world's own was kept."""
    total_error: TotalError
    paths: Callable[[Array], list[ToolPath]]
    trials: Callable[[Array], Array]
    """e_T `(n,)` after each of pushes U `(n, 2)`, tried in copies of the world; for `optimizer=oracle`."""


def look(cell: Cell, previous: Observation | None) -> tuple[Observation, View, float]:
    """Take a picture and make out the object in it; also the seconds this took."""
    began = perf_counter()
    image = cell.world.image()
    seen = cell.perception.observe(image, cell.camera, previous)
    seconds = perf_counter() - began
    return (
        seen,
        View(
            image,
            seen.contour,
            seen.c,
            seen.theta,
            cell.world.nodes(),
            cell.world.joints(),
            cell.world.strain(),
        ),
        seconds,
    )


def know(
    cell: Cell,
    seen: Observation,
    target: Target,
    errors: Errors,
    at_start: float,
    outcome: Outcome | None = None,
    speed: float | None = None,
) -> State:
    """What the optimizer is told of an observation.

    `at_start` is the first e_T, `outcome` and `speed` those of the push before, as far as they are known.
    """
    return State(
        seen.contour,
        seen.c,
        seen.theta,
        cell.push.effective(seen, cell.part),
        target.c,
        target.theta,
        errors.e_T / at_start,
        errors.e_gamma,
        np.nan if outcome is None or outcome.strain is None else outcome.strain.p99_peak,
        partial(pressed, cell, [] if outcome is None else outcome.film),
        partial(pressed, cell, [cell.world.nodes()]),
        np.nan if speed is None else speed,
        cell.task.total_error(target),
        partial(cell.push.paths, seen=seen, part=cell.part),
        partial(try_out, cell=cell, seen=seen, target=target),
    )


def pressed(cell: Cell, looks: Sequence[Array | None]) -> list[Array]:
    """Contours `(M, 2)` (m) of the object where its nodes were as given; none of those that are unknown.

    A silhouette is a little larger than the object's part of the rendered picture, so contours must be
    compared with others of this function only.
    """
    triangles = cell.world.scenery().get("mesh_triangles")
    if triangles is None:
        return []
    blobs = [silhouette(nodes, triangles, cell.camera) for nodes in looks if nodes is not None]
    return [cell.perception.outline(blob, cell.camera) for blob in blobs if blob.any()]


def nearest_reachable(cell: Cell, u: Array, seen: Observation) -> tuple[Array, ToolPath]:
    """The wanted push and its path, or the one nearest along the contour that the robot can reach.

    Raises:
        SimulationError: the robot can reach no push of this length.
    """
    for shift in sorted(np.arange(-50, 51) / 100, key=abs):
        kappa = (u[0] + shift) % 1.0 if cell.part.closed and shift else u[0] + shift
        if 0.0 <= kappa <= 1.0:
            path = cell.push.plan(np.array([kappa, u[1]]), seen, cell.part)
            behind = path.start - cell.push.offset * path.direction  # room to come clear on the way back
            if cell.world.can_reach(np.stack([behind, path.end])).all():
                if shift:
                    log.warning(
                        "kappa = %.3f is out of the robot's reach; pushed at %.3f instead", u[0], kappa
                    )
                return np.array([kappa, u[1]]), path
    raise SimulationError(f"the object lies where the robot can reach no push of {u[1] * 1e3:.0f} mm")


def try_out(U: Array, cell: Cell, seen: Observation, target: Target) -> Array:
    """e_T `(n,)` after each of pushes U `(n, 2)`, made in copies of the world; nan where a push fails."""

    def trial(u: Array) -> float:
        cell.world.push(nearest_reachable(cell, u, seen)[1])
        return cell.task.errors(look(cell, seen)[0], target).e_T

    after = branched([partial(trial, u) for u in U], os.cpu_count() or 1)
    return np.array([np.nan if e_T is None else e_T for e_T in after])
