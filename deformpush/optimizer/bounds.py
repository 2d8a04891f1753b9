"""Where the next push is looked for: `constAdaption` of Algorithm 2 and its alternatives.

Every choice is a pure function of the pushes made so far, so there is nothing to save and nothing to go out
of step.
"""

from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from annotated_types import Interval


class Bounds(Protocol):
    """Outer limits and the part of them that is searched now."""

    @property
    def outer(self) -> np.ndarray:
        """`[[kappa_lo, kappa_hi], [d_lo, d_hi]]`, never exceeded."""

    def now(self, U: np.ndarray, xi: np.ndarray, e_T_share: float | None = None) -> np.ndarray:
        """`(2, 2)` inside `outer`, after pushes U `(S, 2)` that changed e_T by xi `(S,)`.

        `e_T_share` is e_T now over e_T at the start, where it is known.
        """


@dataclass(frozen=True)
class Box:
    """The outer limits, always."""

    d: tuple[float, float]
    """d_min, d_max (m)."""
    kappa: tuple[float, float] = (0.0, 1.0)
    """kappa_min, kappa_max."""

    def __post_init__(self) -> None:
        """Check the limits.

        Raises:
            ValueError: limits that are not in order, or leave [0, 1] for kappa or the positive numbers for d.
        """
        lo, hi = self.d
        if not 0 < lo < hi < np.inf:
            raise ValueError(f"d: [{lo}, {hi}] must satisfy 0 < d_min < d_max (metres)")
        lo, hi = self.kappa
        if not 0 <= lo < hi <= 1:
            raise ValueError(f"kappa: [{lo}, {hi}] must satisfy 0 <= kappa_min < kappa_max <= 1")

    @property
    def outer(self) -> np.ndarray:
        """`[[kappa_lo, kappa_hi], [d_lo, d_hi]]`."""
        return np.array([self.kappa, self.d], float)

    def now(self, U: np.ndarray, xi: np.ndarray, e_T_share: float | None = None) -> np.ndarray:
        """The outer limits."""
        return self.outer


@dataclass(frozen=True)
class Adaptive(Box):
    """`constAdaption`: narrow around the most effective pushes seen lately, open when they stop working.

    The core is the box of the `elite` best pushes of the last `memory` ones, padded by `margin` of the
    outer width on each side. The bounds lie between the core (openness 0) and the outer limits (openness
    1). A push that achieves at least `works` of the best decrease in memory multiplies the openness by
    `narrow`, any other adds `widen`. On a closed contour the core does not wrap around: elites on both
    sides of kappa = 0 simply span everything. Near the goal `taper` lowers d_max for all of this.
    """

    memory: Annotated[int, Interval(ge=1, le=10_000)] = 15
    elite: Annotated[int, Interval(ge=1, le=10_000)] = 3
    margin: Annotated[float, Interval(gt=0, le=0.5)] = 0.1
    works: Annotated[float, Interval(gt=0, le=1)] = 0.25
    narrow: Annotated[float, Interval(gt=0, lt=1)] = 0.6
    widen: Annotated[float, Interval(gt=0, le=1)] = 0.34
    taper: Annotated[float, Interval(ge=0, le=100)] = 0.5
    """Share of the e_T at the start below which d_max falls in proportion; 0: never."""

    def now(self, U: np.ndarray, xi: np.ndarray, e_T_share: float | None = None) -> np.ndarray:
        """Bounds after the history; at least `margin` of the outer width wide, twice that off the limits."""
        outer = self.tapered(e_T_share)
        lately = slice(-self.memory, None)
        effective = xi[lately] < 0
        if not effective.any():
            return outer
        best = U[lately][effective][np.argsort(xi[lately][effective], kind="stable")[: self.elite]]
        best = np.clip(best, *outer.T)
        pad = self.margin * np.diff(self.outer)
        core = np.clip(
            np.stack([best.min(axis=0), best.max(axis=0)], axis=1) + pad * (-1.0, 1.0), *outer.T[:, :, None]
        )
        openness = self.openness(xi)
        return np.clip(core + openness * (outer - core), *outer.T[:, :, None])

    def tapered(self, e_T_share: float | None) -> np.ndarray:
        """The outer limits, d_max lowered in proportion once e_T is below `taper` of its start value."""
        outer = self.outer
        if e_T_share is not None and self.taper > 0:
            lo, hi = outer[1]
            outer[1, 1] = lo + (hi - lo) * np.clip(e_T_share / self.taper, self.margin, 1.0)
        return outer

    def openness(self, xi: np.ndarray) -> float:
        """1 before any push; then each push narrows or widens, in order."""
        openness = 1.0
        for k in range(len(xi)):
            best = xi[max(0, k + 1 - self.memory) : k + 1].min()
            worked = xi[k] < 0 and xi[k] <= self.works * best
            openness = openness * self.narrow if worked else min(1.0, openness + self.widen)
        return openness


@dataclass(frozen=True)
class TrustRegion(Box):
    """A box around the best push that grows with success, shrinks with failure (TuRBO, Eriksson 2019).

    Sides are `length` of the outer width, centred on the best push since the last restart and moved inside
    the outer limits. `successes` improvements in a row double it, up to `longest`; `failures` pushes
    without one in a row halve it; below `shortest` the region starts anew with what comes next. Both sides
    scale alike: the length-scale weights of the original would make the bounds depend on the model.
    """

    length: Annotated[float, Interval(gt=0, le=2)] = 0.8
    longest: Annotated[float, Interval(gt=0, le=2)] = 1.6
    shortest: Annotated[float, Interval(gt=0, lt=1)] = 0.1
    successes: Annotated[int, Interval(ge=1, le=10_000)] = 3
    failures: Annotated[int, Interval(ge=1, le=10_000)] = 4

    def __post_init__(self) -> None:
        """Check the limits.

        Raises:
            ValueError: limits out of order, or lengths not in the order shortest < length <= longest.
        """
        super().__post_init__()
        if not self.shortest < self.length <= self.longest:
            lengths = (self.shortest, self.length, self.longest)
            raise ValueError(f"length: need shortest < length <= longest, got {lengths}")

    def now(self, U: np.ndarray, xi: np.ndarray, e_T_share: float | None = None) -> np.ndarray:
        """The region after replaying the history."""
        length, start, won, lost = self.length, 0, 0, 0
        for k in range(1, len(xi)):
            if k == start:
                continue
            better = xi[k] < xi[start:k].min() - 1e-3 * abs(xi[start:k].min())
            won, lost = (won + 1, 0) if better else (0, lost + 1)
            if won == self.successes:
                length, won = min(2.0 * length, self.longest), 0
            elif lost == self.failures:
                length, lost = length / 2.0, 0
            if length < self.shortest:
                length, start, won, lost = self.length, k + 1, 0, 0
        outer = self.outer
        if start >= len(xi):
            return outer
        centre = U[start:][np.argmin(xi[start:])]
        lo, hi = outer.T
        side = min(length, 1.0) * (hi - lo)
        # hi - side may round to just below lo.
        low = np.clip(centre - side / 2.0, lo, np.maximum(lo, hi - side))
        return np.stack([low, np.minimum(low + side, hi)], axis=1)
