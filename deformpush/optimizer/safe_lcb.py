"""LCB among pushes that are gentle enough: `acquisition=safe_lcb`."""

from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Gt, Interval

from deformpush.gp.fit import MAP, Fit
from deformpush.gp.profiles import Array
from deformpush.mechanics.outline_change import contour_change
from deformpush.model.base import Ingredients
from deformpush.optimizer.acquisition import Context, Objective, OverSurface, lower_confidence
from deformpush.optimizer.safe_set import Allowance, Trend
from deformpush.optimizer.strain_model import LEVEL, Guard

KNOWN = 1.1
"""Factor of a log-normal prior, of what has been measured beforehand."""


@dataclass(frozen=True, eq=False)
class Fenced:
    """An objective with a wall about the allowed pushes: a(u) + steep * max(0, excess(u))."""

    inner: Objective
    allowance: Allowance
    steep: float = 100.0
    """Far above what the acquisition gains along the way, so that minima lie inside."""

    def value(self, U: Array) -> Array:
        """Values `(n,)` at U `(n, 2)`."""
        return np.asarray(self.inner.value(U) + self.steep * np.maximum(self.allowance.excess(U), 0.0))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)`."""
        value, slope = self.inner.gradient(U)
        excess, by_u = self.allowance.gradient(U)
        outside = excess > 0.0
        wall = self.steep * np.where(outside, excess, 0.0)
        return value + wall, slope + self.steep * np.where(outside[:, None], by_u, 0.0)


@dataclass(frozen=True)
class SafeLCB:
    """mu - w sigma of xi (12), over the pushes u with P(peak(u) <= limit) >= p_safe.

    The peak has a Gaussian process of its own, on its logarithm, over the same (kappa, d, t). The allowed set
    begins with the shortest pushes and grows from those that were made, as in SafeOpt (Sui et al. 2015); the
    probability is that of the next push, its scatter included, and not of a whole run.
    """

    limit: Annotated[float, Gt(0)] | None
    """What the peak must stay under: the strain limit of the object (-)."""
    w: Annotated[float, Ge(0)] = 2.0
    """Confidence weight of (12)."""
    p_safe: Annotated[float, Interval(ge=0.5, lt=1)] = 0.95
    signal: Literal["strain", "contour"] = "strain"
    """strain: p99 during the push, as only a simulator knows it. contour: the largest dent in the outline
    during the push, as a camera sees it, times a gain."""
    contour_gain: Annotated[float, Gt(0)] = 4.0
    """Strain per unit of dent: largest distance of outlines laid on each other, over sqrt(area) (-)."""
    contour_scatter: Annotated[float, Ge(0)] = 0.15
    """Standard deviation of log strain about log(gain dent): what the camera does not tell."""
    contour_places: Annotated[float, Gt(0)] = 0.02
    """Standard deviation of log strain between places, as far as dents tell it."""
    growth: Annotated[float, Ge(0)] = 0.2
    """The peak is expected to grow as (d / d_max)^growth, until pushes say otherwise."""
    speed: tuple[Annotated[float, Gt(0)], Annotated[float, Gt(0)]] | None = None
    """Slowest and fastest tool (m/s) that may be chosen: each push is made as fast as is gentle enough."""
    impact_speed: Annotated[float, Gt(0)] = 0.15
    """v_0 (m/s)."""
    impact: tuple[float, Annotated[float, Gt(0)]] = (1.0, 0.5)
    """The peak grows as (1 + (v / v_0)^2)^impact: mean and standard deviation before any push."""
    p_speed: Annotated[float, Interval(ge=0.5, lt=1)] = 0.999
    """As p_safe, but for going faster than the slowest: speed brings a push no nearer to the goal."""
    scale: Annotated[float, Gt(0)] = 0.35
    """By how much log peak may differ between pushes, beside that."""
    fit: Fit = field(default_factory=MAP)

    def __post_init__(self) -> None:
        """Check that there is a limit.

        Raises:
            ValueError: there is none, or the speeds are in the wrong order.
        """
        if self.limit is None:
            raise ValueError("limit: safe_lcb needs one; this object's strain_limit is null")
        if self.speed is not None and self.speed[0] > self.speed[1]:
            raise ValueError(f"speed: {list(self.speed)} must be [slowest, fastest]")

    def guard(self, parts: Ingredients) -> Guard:
        """What learns the peaks."""
        from scipy.special import ndtri

        assert self.limit is not None
        lo, hi = parts.outer[1]
        return Guard(
            self._peak,
            parts.kernel,
            self._fit(),
            limit=self.limit,
            z=float(ndtri(self.p_safe)),
            z_speed=float(ndtri(max(self.p_safe, self.p_speed))),
            scale=self.scale,
            scatter=self.contour_scatter if self.signal == "contour" else 0.0,
            trend=Trend(
                self.growth,
                (float(lo), float(hi)),
                self.impact_speed,
                (float(np.log(self.limit)), LEVEL * self.scale),
                (0.0, 0.0) if self.speed is None else self.impact,
            ),
            speeds=self.speed,
        )

    def objective(self, context: Context) -> Objective:
        """The bound over the surface of now, walled in by what is allowed."""
        inner = OverSurface(context.surface, lambda mu, sigma: lower_confidence(mu, sigma, self.w))
        allowance = context.allowance
        return inner if allowance is None or allowance.learnt is None else Fenced(inner, allowance)

    def _fit(self) -> Fit:
        """How the process on log peak is fitted.

        Dents tell how much this object is strained, and hardly at which place more than at the next
        (docs/strain.md). How much of either is known, and not left to the likelihood of a dozen dents.
        """
        if self.signal == "strain" or not isinstance(self.fit, MAP):
            return self.fit
        sigma_f, noise = self.contour_places / self.scale, self.contour_scatter / self.scale
        return replace(self.fit, sigma_f=(sigma_f, KNOWN), noise=(max(noise, self.fit.noise[0]), KNOWN))

    def _peak(self, before: Any, after: Any) -> float:
        if self.signal == "strain":
            return float(after.strain)
        dents = [contour_change(rest, look).dent for rest in before.at_rest() for look in after.pressed()]
        return self.contour_gain * max(dents, default=float("nan"))
