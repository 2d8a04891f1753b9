"""How the peak strain of a push grows with its length and speed."""

from dataclasses import dataclass

import numpy as np

from deformpush.gp.profiles import Array, ArrayOrFloat
from deformpush.model.coordinates import share_of_longest


@dataclass(frozen=True)
class StrainTrend:
    """What is known of log peak before any push, beside that places differ.

    growth log(d / d_max) + level + impact log(1 + (v / v_0)^2): it grows with the distance, and with the
    speed. Bringing the object to the tool's speed v costs a force beside that of friction, which grows with
    v^2 for a tool that meets it in motion. Level and impact are Gaussian and learnt.
    """

    growth: float
    d: tuple[float, float]
    """d_min, d_max (m)."""
    v_0: float
    """m/s."""
    level: tuple[float, float]
    """Mean and standard deviation."""
    impact: tuple[float, float]
    """The same; (0, 0) where the speed is not free."""

    def expected(self, U: Array, v: ArrayOrFloat) -> Array:
        """At U `(n, 2)` in model coordinates and speeds v (m/s), before any push `(n,)`."""
        distance = self.growth * np.log(share_of_longest(U, self.d))
        return np.asarray(distance + self.basis(len(U), v) @ [self.level[0], self.impact[0]])

    def basis(self, n: int, v: ArrayOrFloat) -> Array:
        """What level and impact are multiplied with `(n, 2)`, at speeds v (m/s), one or n."""
        return np.column_stack([np.ones(n), np.broadcast_to(np.log1p((v / self.v_0) ** 2), n)])

    @property
    def spread(self) -> Array:
        """Standard deviations of level and impact `(2,)`; what is certain is a hair from it."""
        return np.maximum([self.level[1], self.impact[1]], 1e-6)

    def slope(self, U: Array) -> Array:
        """Derivative of `expected` by the second coordinate `(n,)`."""
        lo, hi = self.d
        return np.asarray(self.growth * (hi - lo) / (lo + U[:, 1] * (hi - lo)))
