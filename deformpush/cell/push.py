"""From u = (kappa, d) to the path of the tool: effective contour, augmented contour (5), contact, retreat."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from annotated_types import Interval

from deformpush.cell.effective import Effective
from deformpush.cell.observation import FirstLook, Observation
from deformpush.cell.pushable import pushable
from deformpush.mechanics import rounding
from deformpush.mechanics.rounding import METRES, rounded

Array = np.ndarray


@dataclass(frozen=True)
class ToolPath:
    """A straight push in the plane (table frame, metres): start -> contact -> end, and back the same way."""

    start: Array
    """Tool centre `(2,)` where the push begins, clear of the object."""
    direction: Array
    """Unit vector `(2,)`."""
    approach: float
    """Travel from start until the tool touches the object."""
    d: float
    """Travel from there on."""
    speed: float | None = None
    """Of the tool on its way forth (m/s); None: as the world is set."""

    @property
    def contact(self) -> Array:
        """Tool centre at first touch `(2,)`."""
        return self.start + self.approach * self.direction

    @property
    def end(self) -> Array:
        """Tool centre at the end of the push `(2,)`."""
        return self.start + (self.approach + self.d) * self.direction

    def rounded(self) -> "ToolPath":
        """As a robot is given it: the same on every machine, see `deformpush.mechanics.rounding`."""
        start, direction = rounded(self.start, METRES), rounding.direction(self.direction)
        approach, d = (float(rounded(x, METRES)) for x in (self.approach, self.d))
        return ToolPath(start, direction, approach, d, self.speed)


@dataclass(frozen=True)
class Line:
    """Where pushes may begin, in the order of kappa; what is left out between two points has no length."""

    index: Array
    """Of the contour points that they belong to `(M_e,)`."""
    points: Array
    """Of V_e `(M_e, 2)` (m)."""
    length: Array
    """Of V_e from kappa = 0 to each of them `(M_e,)` (m)."""

    @classmethod
    def of(cls, index: Array, points: Array, m: int) -> "Line":
        """Measure V_e, of a contour of `m` points."""
        step = np.linalg.norm(np.diff(points, axis=0), axis=1)
        step[(np.diff(index) - 1) % m != 0] = 0.0
        return cls(index, points, np.append(0.0, np.cumsum(step)))

    @property
    def kappa(self) -> Array:
        """Of each point `(M_e,)`."""
        return self.length / self.length[-1]

    def at(self, kappa: float) -> float:
        """Fractional index at a share kappa of the length."""
        share = np.clip(kappa, 0.0, 1.0)
        return float(np.interp(share * self.length[-1], self.length, np.arange(len(self.length))))

    def places(self, n: int) -> Array:
        """Points `(n, 2)` (m) at even steps of kappa from 0 to 1."""
        return np.array([_interpolate(self.points, self.at(kappa)) for kappa in np.linspace(0.0, 1.0, n)])


@dataclass(frozen=True)
class Push:
    """How a push is laid out around the object."""

    offset: Annotated[float, Interval(gt=0, le=1)]
    """d_o of (5): the tool waits this far outside the contour (m). More than the tool's radius."""
    augment: Literal["radial", "normal"]
    """Direction of d_o: away from the centroid, as (5) is printed, or along the contour's outward normal."""
    tool_radius: Annotated[float, Interval(ge=5e-4, le=0.2)]
    """Radius of the cylindrical tool (m)."""
    contact_margin: Annotated[float, Interval(ge=0, le=0.1)] | None
    """The simulated contact acts this far outside the visible contour (m); None: as the world says."""
    clearance: Annotated[float, Interval(gt=0, le=0.1)]
    """A start nearer to the object than this, beyond touching, is moved back along the push line (m)."""

    def __post_init__(self) -> None:
        if self.offset <= self.tool_radius:
            raise ValueError(f"offset: {self.offset:g} must be larger than tool_radius {self.tool_radius:g}")

    @property
    def reach(self) -> float:
        """Distance between tool centre and contour at touch (m)."""
        return self.tool_radius + (self.contact_margin or 0.0)

    def augmented(self, contour: Array, c: Array) -> Array:
        """V_s `(M, 2)`: v_s = v + d_o v_b / |v_b|, v_b = v - c (5), or the same along the outward normal."""
        if self.augment == "normal":
            return contour - self.offset * self.inward(contour)
        outward = contour - c
        return contour + self.offset * outward / np.linalg.norm(outward, axis=1, keepdims=True)

    def inward(self, contour: Array) -> Array:
        """Unit inward normals `(M, 2)` of a counter-clockwise contour, taken over the width of the tool."""
        spacing = np.linalg.norm(contour - np.roll(contour, -1, axis=0), axis=1).mean()
        half = max(1, round(self.tool_radius / spacing))
        chord = np.roll(contour, -half, axis=0) - np.roll(contour, half, axis=0)
        normal = np.stack([-chord[:, 1], chord[:, 0]], axis=1)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def effective(self, seen: Observation, part: Effective) -> "Line":
        """V_e from kappa = 0 to kappa = 1: a part of V_s, without what the tool cannot push.

        That is known from the first look where later contours are followed from there; without, as in the
        paper, nothing is left out.
        """
        index = part.indices(seen)
        if seen.first is not None and seen.first.followed:
            index = index[_pushable_at_first(self, seen.first)[index]]
        return Line.of(index, self.augmented(seen.contour, seen.c)[index], len(seen.contour))

    def pushable(self, contour: Array, c: Array, approach: float = np.inf) -> Array:
        """Which points of a contour `(M, 2)` the tool can push, coming straight over `approach` metres."""
        return pushable(contour, self.augmented(contour, c), self.inward(contour), self.reach, approach)

    def plan(self, u: Array, seen: Observation, part: Effective) -> ToolPath:
        """The path of push u = (kappa, d); see `paths`."""
        return self.paths(np.asarray(u)[None], seen, part)[0]

    def paths(self, U: Array, seen: Observation, part: Effective) -> list[ToolPath]:
        """The paths of pushes U `(n, 2)`, each u = (kappa, d).

        kappa is a share of the arc length of the effective contour; the tool moves perpendicular to the
        contour segment there, and d counts from the touch. A line that misses the object (glancing past a
        corner) is pushed as if the touch were where the tool passes the contour point.
        """
        line = self.effective(seen, part)
        inward, contour = self.inward(seen.contour)[line.index], seen.contour[line.index]
        paths = []
        for kappa, d in U:
            at = line.at(kappa)
            start = _interpolate(line.points, at)
            direction = _interpolate(inward, at)
            direction /= np.linalg.norm(direction)
            approach = touch(start, direction, seen.contour, self.reach)
            if approach is None:
                approach = float((_interpolate(contour, at) - start) @ direction)
            back = max(0.0, self.clearance - approach)
            paths.append(ToolPath(start - back * direction, direction, approach + back, float(d)))
        return paths


def touch(start: Array, direction: Array, contour: Array, reach: float) -> float | None:
    """Signed travel from `start` along `direction` until a disc of radius `reach` first touches the contour.

    Each contour point p is touched at travel a - sqrt(reach^2 - b^2), where a and b are its coordinates along
    and across the line; the first touch over all points counts. A negative travel means that the start
    overlaps the object. None if the line misses.
    """
    relative = contour - start
    along = relative @ direction
    across = relative @ np.array([-direction[1], direction[0]])
    hit = np.abs(across) < reach
    if not hit.any():
        return None
    return float(np.min(along[hit] - np.sqrt(reach**2 - across[hit] ** 2)))


def _interpolate(values: Array, at: float) -> Array:
    """Rows of `values` linearly interpolated at a fractional index."""
    low = min(int(at), len(values) - 2)
    share = at - low
    return (1 - share) * values[low] + share * values[low + 1]


@lru_cache(maxsize=8)
def _pushable_at_first(layout: Push, first: FirstLook) -> Array:
    return layout.pushable(first.body, np.zeros(2))
