"""Any acquisition among pushes that are gentle enough: `acquisition=safe_lcb`, `acquisition=safe_ei`.

Safe(limit=0.12, inner=EI())
"""

from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt, Interval

from deformpush.cell.world import Capability
from deformpush.gp.fit import MAP, Fit
from deformpush.mechanics.outline_change import contour_change
from deformpush.model.base import ModelComponents
from deformpush.optimizer.acquisition import LCB, Acquisition, Context
from deformpush.optimizer.objective import Objective
from deformpush.optimizer.strain_model import LEVEL, StrainModel
from deformpush.optimizer.strain_trend import StrainTrend
from deformpush.state import State

Speed = Annotated[float, Interval(ge=1e-3, le=10)]
"""Of the tool (m/s)."""
KNOWN = 1.1
"""Factor of a log-normal prior, of what has been measured beforehand."""


@dataclass(frozen=True)
class Safe(Acquisition):
    """The inner acquisition over the pushes u with P(peak(u) <= limit) >= p_safe.

    The peak has a Gaussian process of its own, on its logarithm, over the same (kappa, d, t). The allowed set
    begins with the shortest pushes and grows from those that were made, as in SafeOpt (Sui et al. 2015); the
    probability is that of the next push, its scatter included, and not of a whole run.
    """

    limit: Annotated[float, Gt(0)] | None
    """What the peak must stay under: the strain limit of the object (-)."""
    inner: Acquisition = field(default_factory=LCB)
    """What is minimised among the pushes that are gentle enough."""
    p_safe: Annotated[float, Interval(ge=0.5, lt=1)] = 0.95
    signal: Literal["strain", "contour"] = "strain"
    """strain: p99 during the push, as only a simulator knows it. contour: the largest dent in the outline
    during the push, as a camera sees it, times a gain."""
    contour_gain: Annotated[float, Interval(ge=1e-3, le=1e3)] = 4.0
    """Strain per unit of dent: largest distance of outlines laid on each other, over sqrt(area) (-)."""
    contour_scatter: Annotated[float, Interval(ge=0, le=10)] = 0.15
    """Standard deviation of log strain about log(gain dent): what the camera does not tell."""
    contour_places: Annotated[float, Interval(ge=1e-4, le=10)] = 0.02
    """Standard deviation of log strain between places, as far as dents tell it."""
    growth: Annotated[float, Interval(ge=0, le=10)] = 0.2
    """The peak is expected to grow as (d / d_max)^growth, until pushes say otherwise."""
    speed: tuple[Speed, Speed] | None = None
    """Slowest and fastest tool (m/s) that may be chosen: each push is made as fast as is gentle enough."""
    impact_speed: Speed = 0.15
    """v_0 (m/s)."""
    impact: tuple[
        Annotated[float, Interval(ge=-100, le=100)], Annotated[float, Interval(ge=1e-3, le=100)]
    ] = (1.0, 0.5)
    """The peak grows as (1 + (v / v_0)^2)^impact: mean and standard deviation before any push."""
    p_speed: Annotated[float, Interval(ge=0.5, lt=1)] = 0.999
    """As p_safe, but for going faster than the slowest: speed brings a push no nearer to the goal."""
    scale: Annotated[float, Interval(ge=1e-3, le=10)] = 0.35
    """By how much log peak may differ between pushes, beside that."""
    fit: Fit = field(default_factory=MAP)

    def __post_init__(self) -> None:
        """Check that there is a limit.

        Raises:
            ValueError: there is none, or the speeds are in the wrong order.
        """
        if self.limit is None:
            raise ValueError("limit: a safe acquisition needs one; this object's strain_limit is null")
        if self.speed is not None and self.speed[0] > self.speed[1]:
            raise ValueError(f"speed: {list(self.speed)} must be [slowest, fastest]")

    @property
    def needs(self) -> frozenset[Capability]:
        """What the signal is measured by, and what the inner acquisition needs."""
        measured: Capability = "strain" if self.signal == "strain" else "film"
        return self.inner.needs | {measured}

    def constraint(self, parts: ModelComponents) -> StrainModel:
        """What learns the peaks."""
        from scipy.special import ndtri

        assert self.limit is not None
        lo, hi = parts.outer[1]
        return StrainModel(
            self._peak,
            parts.kernel,
            self._fit(),
            limit=self.limit,
            z=float(ndtri(self.p_safe)),
            z_speed=float(ndtri(max(self.p_safe, self.p_speed))),
            scale=self.scale,
            scatter=self.contour_scatter if self.signal == "contour" else 0.0,
            trend=StrainTrend(
                self.growth,
                (float(lo), float(hi)),
                self.impact_speed,
                (float(np.log(self.limit)), LEVEL * self.scale),
                (0.0, 0.0) if self.speed is None else self.impact,
            ),
            speeds=self.speed,
        )

    def objective(self, context: Context) -> Objective:
        """The inner objective, walled in by what is allowed."""
        return context.feasible.walled(self.inner.objective(context))

    def _fit(self) -> Fit:
        """How the process on log peak is fitted.

        Dents tell how much this object is strained, and hardly at which place more than at the next
        (docs/strain.md). How much of either is known, and not left to the likelihood of a dozen dents.
        """
        if self.signal == "strain" or not isinstance(self.fit, MAP):
            return self.fit
        sigma_f, noise = self.contour_places / self.scale, self.contour_scatter / self.scale
        return replace(self.fit, sigma_f=(sigma_f, KNOWN), noise=(max(noise, self.fit.noise[0]), KNOWN))

    def _peak(self, before: State, after: State) -> float:
        """The peak of the push between two states; nan where it was not measured."""
        if self.signal == "strain":
            return np.nan if after.strain is None else after.strain
        rest = before.at_rest
        dents = [] if rest is None else [contour_change(rest, look).dent for look in after.pressed]
        return self.contour_gain * max(dents, default=np.nan)


@dataclass(frozen=True)
class SafeLCB(Safe):
    """`Safe` around LCB (12), whose weight is a setting of its own: `acq.w`."""

    w: Annotated[float, Interval(ge=0, le=1e6)] = 2.0
    """Confidence weight of (12)."""
    inner: Acquisition = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Make the inner acquisition; errors as in `Safe`."""
        super().__post_init__()
        object.__setattr__(self, "inner", LCB(self.w))
