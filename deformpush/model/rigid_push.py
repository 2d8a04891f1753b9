"""Prior mean of the motion: what a rigid body would do under the same push."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from annotated_types import Interval

from deformpush.gp.correlation import LogNormal
from deformpush.gp.profiles import ArrayOrFloat
from deformpush.mechanics.geometry import gyration, rotation
from deformpush.mechanics.quasi_static import pushed
from deformpush.mechanics.rounding import lowest
from deformpush.state import State

Array = np.ndarray

PRESSURES = np.geomspace(0.4, 2.5, 10)
"""Pressure radii that past pushes are worked out for, as shares of the radius of gyration."""


@dataclass(frozen=True)
class RigidPush:
    """Quasi-static pushing under an ellipsoidal limit surface, its two free numbers learnt from the pushes.

    A push of d moves a rigid body as `deformpush.mechanics.quasi_static` says once the tool has travelled
    `slip` after the touch: that much goes into denting the object and comes back. Both numbers are the
    maximum a posteriori over the latest pushes; the Gaussian processes learn what is left.
    """

    slip: tuple[Annotated[float, Interval(ge=0, le=0.1)], Annotated[float, Interval(ge=1e-5, le=0.1)]] = (
        0.003,
        0.003,
    )
    """Mean and standard deviation of its prior (m)."""
    pressure_radius: LogNormal = (0.9, 1.4)
    """Ratio of frictional moment to force, as a share of the radius of gyration of the outline."""
    deviation: Annotated[float, Interval(ge=1e-3, le=1e3)] = 0.3
    """What softness adds, as a share of the longest push: scale of the Gaussian processes."""
    lines: Annotated[int, Interval(ge=8, le=1024)] = 96
    """Places along the effective contour that a decision works out."""
    step: Annotated[float, Interval(ge=1e-4, le=0.1)] = 0.002
    """Tool travel between two contact solutions (m)."""
    memory: Annotated[int, Interval(ge=1, le=10_000)] = 40
    """Pushes that the two numbers are learnt from."""


@dataclass(frozen=True)
class Lines:
    """Straight pushes at an object in its own frame: the touch, the way, the outline they meet."""

    body: Array
    """`(M, 2)` (m)."""
    contact: Array
    """`(n, 2)` (m)."""
    direction: Array
    """`(n, 2)`."""
    reach: float
    gyration: float

    @classmethod
    def of(cls, state: State, U: Array) -> "Lines":
        """Pushes U `(n, 2)`, d in metres, at the object as `state` has it."""
        seen, paths = state.seen, state.paths(U)
        turn = rotation(seen.theta)
        contact = (np.array([path.contact for path in paths]) - seen.c) @ turn
        direction = np.array([path.direction for path in paths]) @ turn
        body = (seen.contour - seen.c) @ turn
        gaps = np.linalg.norm(contact[:, None] - body, axis=2).min(axis=1)
        # Lines that miss the object are laid out as if they touched it; the others all touch at the same gap.
        return cls(body, contact, direction, float(np.median(gaps)), gyration(body))

    def pushed(self, pressure: ArrayOrFloat, travel: Array) -> Array:
        """Motion `(n, T, 3)` in the object's frame; pressure as a share of the radius of gyration."""
        return pushed(self.body, self.contact, self.direction, self.reach, pressure * self.gyration, travel)


class Experience:
    """What rigid bodies of every pressure radius would have done in the pushes made so far."""

    def __init__(self, spec: RigidPush, d_max: float, newest: int) -> None:
        """Nothing pushed yet; no push is longer than `d_max` (m), and the `newest` pushes are kept."""
        self.spec, self.newest = spec, max(newest, spec.memory)
        self.travel = np.linspace(0.0, d_max, max(2, round(d_max / spec.step) + 1))
        self.tables = np.empty((0, len(PRESSURES), len(self.travel), 3))
        self.distances = np.empty(0)
        self.slip, self.pressure = spec.slip[0], spec.pressure_radius[0]

    def table(self, state: State, u: Array) -> tuple[Array, float]:
        """Motion `(P, T, 3)` for each pressure radius and travel, and the push's d."""
        one = Lines.of(state, u[None])
        n = len(PRESSURES)
        all_of_them = Lines(
            one.body, np.tile(one.contact, (n, 1)), np.tile(one.direction, (n, 1)), one.reach, one.gyration
        )
        return all_of_them.pushed(PRESSURES, self.travel), float(u[1])

    def keep(self, table: Array, d: float) -> None:
        """Append one push."""
        late = slice(-self.newest, None)
        self.tables = np.concatenate([self.tables, table[None]])[late]
        self.distances = np.append(self.distances, d)[late]

    def learn(self, Y: Array, unit: Array) -> None:
        """Choose slip and pressure radius for motions Y `(S, 3)`; residuals count in units `(3,)`.

        Large residuals count linearly (Huber): one push that glanced off must not bend both numbers.
        """
        late = slice(-self.spec.memory, None)
        m, sd = self.spec.slip
        Y = Y[-len(self.tables) :]
        slips = np.linspace(0.0, min(m + 3 * sd, self.travel[-1]), 25)
        logs = np.linspace(np.log(PRESSURES[0]), np.log(PRESSURES[-1]), 37)
        motion = self._predict(slips, logs, late)
        off = np.abs(Y[late, None, None] - motion) / unit
        cost = np.where(off < 1.0, 0.5 * off**2, off - 0.5).sum(axis=(0, 3))
        median, factor = self.spec.pressure_radius
        cost += 0.5 * ((slips - m) / sd) ** 2
        cost += 0.5 * ((logs[:, None] - np.log(median)) / np.log(factor)) ** 2
        i, j = np.unravel_index(lowest(cost.ravel()), cost.shape)
        self.pressure, self.slip = float(np.exp(logs[i])), float(slips[j])

    def means(self) -> Array:
        """Predicted motions `(n, 3)` of the pushes that are kept, oldest first."""
        slip, log = np.array([self.slip]), np.array([np.log(self.pressure)])
        return self._predict(slip, log, slice(None))[:, 0, 0]

    def field(self, state: State, outer: Array, closed: bool) -> "RigidField":
        """The prior mean over all pushes at the object as `state` has it."""
        lo, hi = outer[0]
        kappa = np.linspace(lo, hi, self.spec.lines + 1)
        U = np.column_stack([kappa, np.full(len(kappa), outer[1, 1])])
        if closed and hi - lo == 1.0:
            motion = Lines.of(state, U[:-1]).pushed(self.pressure, self.travel)
            motion = np.concatenate([motion, motion[:1]])
        else:
            motion = Lines.of(state, U).pushed(self.pressure, self.travel)
        return RigidField(kappa, self.travel, motion, self.slip, outer[1])

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""
        return {"rigid_tables": self.tables.copy(), "rigid_distances": self.distances.copy()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""
        self.tables = np.array(state["rigid_tables"], float)
        self.distances = np.array(state["rigid_distances"], float)

    def _predict(self, slips: Array, logs: Array, which: slice) -> Array:
        """Motions `(S, L, D, 3)` for L pressure radii (their logarithms) and D slips."""
        tables, d = self.tables[which], self.distances[which]
        low, share, _ = _cell(np.log(PRESSURES), logs)
        share = share[:, None, None]
        tables = (1 - share) * tables[:, low] + share * tables[:, low + 1]  # (S, L, T, 3)
        low, share, _ = _cell(self.travel, d[:, None] - slips)
        share = share[:, None, :, None]
        rows = np.arange(len(d))[:, None, None]
        columns = np.arange(len(logs))[None, :, None]
        low = low[:, None, :]
        return np.asarray((1 - share) * tables[rows, columns, low] + share * tables[rows, columns, low + 1])


@dataclass(frozen=True, eq=False)
class RigidField:
    """Prior mean of dx, dy, dtheta over (kappa, d), bilinear between the lines and travels worked out."""

    kappa: Array
    travel: Array
    motion: Array
    """`(K, T, 3)`."""
    slip: float
    d: Array
    """d_min, d_max (m)."""

    def at(self, U: Array) -> tuple[Array, Array]:
        """Motion `(n, 3)` at U `(n, 2)` in model coordinates, and its slopes `(n, 3, 2)`."""
        lo, hi = self.d
        i, a, rise = _cell(self.kappa, U[:, 0])
        j, b, run = _cell(self.travel, lo + U[:, 1] * (hi - lo) - self.slip)
        near, far = self.motion[i], self.motion[i + 1]
        rows = np.arange(len(U))
        a, b = a[:, None], b[:, None]
        low = (1 - a) * near[rows, j] + a * far[rows, j]
        high = (1 - a) * near[rows, j + 1] + a * far[rows, j + 1]
        across = (1 - b) * (far[rows, j] - near[rows, j]) + b * (far[rows, j + 1] - near[rows, j + 1])
        slopes = np.stack([across * rise[:, None], (high - low) * run[:, None] * (hi - lo)], axis=2)
        return (1 - b) * low + b * high, slopes


def _cell(ticks: Array, x: Array) -> tuple[Array, Array, Array]:
    """Cell of evenly spaced ticks that x lies in, the share of it, and that share's slope (0 outside)."""
    width = ticks[1] - ticks[0]
    at = (x - ticks[0]) / width
    inside = (at >= 0) & (at <= len(ticks) - 1)
    at = np.clip(at, 0.0, len(ticks) - 1)
    cell = np.minimum(at.astype(int), len(ticks) - 2)
    return cell, at - cell, inside / width
