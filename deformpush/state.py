"""What passes between the loop and an optimizer: what it may know, and what it answers. Plain data."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from deformpush.cell.effective import Effective
from deformpush.cell.observation import Observation
from deformpush.cell.push import Line, Push, ToolPath
from deformpush.mechanics.rounding import reported
from deformpush.task import Errors, Target, TotalError, Weights

Array = np.ndarray


@dataclass(frozen=True)
class State:
    """What an optimizer may know of the object between two pushes."""

    seen: Observation
    target: Target
    errors: Errors
    e_T_share: float
    """e_T over its value at the start."""
    weights: Weights
    """Of the total error (4)."""
    layout: Push
    """How a push is laid out around the object."""
    part: Effective
    """Which part of the contour may be pushed."""
    speed: float | None = None
    """Tool speed of the push that led here (m/s); None where the world's own was kept."""
    strain: float | None = None
    """Peak p99 strain of that push (-); None before any, and where it is not measured."""
    pressed: tuple[Array, ...] = ()
    """Contours `(M, 2)` (m) during that push, picture by picture, for an optimizer that needs `film`."""
    at_rest: Array | None = None
    """The contour now, made out in the same way; None where `pressed` is not made out."""

    @cached_property
    def effective(self) -> Line:
        """V_e from kappa = 0 to kappa = 1."""
        return self.layout.effective(self.seen, self.part)

    @cached_property
    def total_error(self) -> TotalError:
        """e_T (4) of where the object may come to lie."""
        return TotalError(self.target, self.weights)

    def paths(self, U: Array) -> list[ToolPath]:
        """Where pushes U `(n, 2)`, d in metres, would go."""
        return self.layout.paths(U, self.seen, self.part)


@dataclass(frozen=True)
class Forecast:
    """Where a push is expected to bring the object (table frame, metres, radians)."""

    mean: Array
    """Centroid x, y, angle, shape error (3) after the push `(4,)`."""
    cov: Array
    """Their covariance `(4, 4)`, noise included."""


@dataclass(frozen=True)
class Proposal:
    """A push to make next. `nan` where there is no model (initial design, random, greedy)."""

    u: Array
    """(kappa, d) `(2,)`, d in metres."""
    phase: str
    """initial | exploit | explore."""
    bounds: Array
    """`[[kappa_min, kappa_max], [d_min, d_max]]` that u was chosen within."""
    acq: float = float("nan")
    mean: float = float("nan")
    """Of xi."""
    std: float = float("nan")
    """Of xi."""
    info: dict[str, float] = field(default_factory=dict)
    """Named numbers worth a look: length scales, noise, jitter, evaluations."""
    forecast: Forecast | None = None
    """Only from models that know where the object will go."""
    speed: float | None = None
    """Of the tool (m/s), where it is chosen too; None: as the world is set."""

    def reported(self) -> "Proposal":
        """As it is written down: with as many digits of what is only told as are the same everywhere."""
        acq, mean, std = (reported(x) for x in (self.acq, self.mean, self.std))
        info = {name: reported(x) for name, x in self.info.items()}
        return replace(self, acq=acq, mean=mean, std=std, info=info)
