"""Which pushes are gentle enough, by what is known of the strain they cause."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from deformpush.gp.profiles import Array
from deformpush.gp.trend import Trended

GRID = (64, 24)
"""Pushes over (kappa, d) among which an allowed one is looked for."""
SPEEDS = 33
"""Speeds among which the fastest allowed one is looked for."""


@dataclass(frozen=True)
class Trend:
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

    def expected(self, U: Array, v: Any) -> Array:
        """At U `(n, 2)` in model coordinates and speeds v (m/s), before any push `(n,)`."""
        lo, hi = self.d
        distance = self.growth * np.log((lo + U[:, 1] * (hi - lo)) / hi)
        return np.asarray(distance + self.basis(len(U), v) @ [self.level[0], self.impact[0]])

    def basis(self, n: int, v: Any) -> Array:
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


@dataclass(frozen=True, eq=False)
class Allowance:
    """Where the probability that the peak of the next push stays under the limit is p_safe or more."""

    learnt: Trended | None
    """Of log peak less what was expected of it; None before the first push."""
    noise: float
    """Standard deviation of what a repeated push would give."""
    trend: Trend
    log_limit: float
    z: float
    """The quantile of p_safe."""
    z_speed: float
    """The quantile of what must be left when a push is made faster."""
    speeds: tuple[float, float]
    """Slowest and fastest (m/s) that may be chosen now; alike where the speed is not free."""

    def peak(self, U: Array, v: float | None = None) -> tuple[Array, Array]:
        """Mean and standard deviation of log peak, each `(n,)`, of pushes U `(n, 2)` at speed v (m/s).

        By default at the slowest speed: a push is allowed if it is at any. Needs at least one push.
        """
        assert self.learnt is not None
        v = self.speeds[0] if v is None else v
        mu, sigma = self.learnt.predict(U, self.trend.basis(len(U), v))
        return mu + self.trend.expected(U, v), np.hypot(sigma, self.noise)

    def excess(self, U: Array, v: float | None = None) -> Array:
        """Upper bound of log peak less log limit `(n,)` at U `(n, 2)`: allowed where it is not above zero."""
        if self.learnt is None:
            return np.full(len(U), np.inf)
        mu, sigma = self.peak(U, v)
        return np.asarray(mu + self.z * sigma - self.log_limit)

    def fastest(self, u: Array) -> float:
        """The speed (m/s) up to which push u `(2,)` is gentle enough by z_speed, the slowest if none is."""
        from scipy.optimize import brentq

        if self.learnt is None:
            return self.speeds[0]

        def over(v: float) -> float:
            mu, sigma = self.peak(u[None], v)
            return float(mu[0] + self.z_speed * sigma[0] - self.log_limit)

        tried = np.linspace(*self.speeds, SPEEDS).tolist()
        if self.speeds[0] == self.speeds[1] or over(tried[0]) > 0.0:
            return self.speeds[0]
        for slower, faster in pairwise(tried):
            if over(faster) > 0.0:
                return float(brentq(over, slower, faster, xtol=1e-12))
        return self.speeds[1]

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """The excess `(n,)` and its gradient `(n, 2)`; needs at least one push."""
        assert self.learnt is not None
        v = self.speeds[0]
        mu, sigma, dmu, dsigma = self.learnt.gradient(U, self.trend.basis(len(U), v))
        total = np.hypot(sigma, self.noise)
        value = mu + self.trend.expected(U, v) + self.z * total - self.log_limit
        slope = dmu + self.z * (sigma / total)[:, None] * dsigma
        slope[:, 1] += self.trend.slope(U)
        return value, slope

    def probability(self, u: Array, v: float) -> float:
        """P(peak of push u `(2,)` at speed v (m/s) <= limit); nan before the first push."""
        if self.learnt is None:
            return float("nan")
        from scipy.special import ndtr

        mu, sigma = self.peak(u[None], v)
        return float(ndtr((self.log_limit - mu[0]) / sigma[0]))

    def shortest(self, box: Array) -> tuple[Array, Array]:
        """The shortest pushes `(n, 2)` of a box, and by how much log peak is expected over the limit `(n,)`.

        Expected, at the slowest speed, and not sure: what is known of other places does not reach them. As in
        SafeOpt, learning begins at pushes that are held to be safe beforehand; there are none gentler.
        """
        shortest = _shortest(box)
        if self.learnt is None:
            return shortest, np.zeros(len(shortest))
        return shortest, self.peak(shortest)[0] - self.log_limit

    def nearest(
        self, u: Array, cost: Callable[[Array], Array], boxes: list[Array]
    ) -> tuple[Array, dict[str, float]]:
        """A push in place of u `(2,)` if that is not allowed, and a note for the record.

        The allowed push of the lowest cost in the first of the `boxes` that holds any. Where nothing is known
        to be allowed, the gentlest: the shortest push, where the peak is expected lowest.
        """
        if float(self.excess(u[None])[0]) <= 0.0:
            return u, {}
        for box in boxes:
            grid = _grid(box)
            allowed = grid[self.excess(grid) <= 0.0]
            if len(allowed):
                return allowed[np.argmin(cost(allowed))], {"held_back": 1.0}
        shortest = _shortest(boxes[-1])
        if self.learnt is None:
            return np.array([u[0], shortest[0, 1]]), {"no_safe_push": 1.0}
        # By what is expected, not by the bound: that would repeat the push that is known best for ever.
        return shortest[np.argmin(self.peak(shortest)[0])], {"no_safe_push": 1.0}


def _grid(box: Array) -> Array:
    """Pushes `(n, 2)` over box `[[lo, hi], [lo, hi]]`, its sides included."""
    kappa, d = np.meshgrid(*(np.linspace(lo, hi, n) for (lo, hi), n in zip(box, GRID, strict=True)))
    return np.column_stack([kappa.ravel(), d.ravel()])


def _shortest(box: Array) -> Array:
    """Of those, the pushes of the least d."""
    grid = _grid(box)
    return np.asarray(grid[grid[:, 1] == grid[:, 1].min()])
