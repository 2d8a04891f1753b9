"""Which pushes are gentle enough, by what is known of the strain they cause, and which of them is made."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from deformpush.gp.profiles import Array
from deformpush.gp.trend import TrendPosterior
from deformpush.mechanics.rounding import lowest
from deformpush.model.base import Posterior, Surface
from deformpush.model.coordinates import grid_over
from deformpush.optimizer.constraint import Choice
from deformpush.optimizer.objective import Objective
from deformpush.optimizer.strain_trend import StrainTrend

GRID = (64, 24)
"""Pushes over (kappa, d) among which an allowed one is looked for."""
SPEEDS = 33
"""Speeds among which the fastest allowed one is looked for."""
BRINK = 1e-4
"""A push counts as allowed up to this far over the limit (of log strain: 0.01 %).

Searches end at the limit itself, where the last bit would say whether a push is allowed.
"""


@dataclass(frozen=True, eq=False)
class SafeSet:
    """Where the probability that the peak of the next push stays under the limit is p_safe or more."""

    learnt: TrendPosterior | None
    """Of log peak less what was expected of it; None before the first push."""
    noise: float
    """Standard deviation of what a repeated push would give."""
    trend: StrainTrend
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

    def constraint(self, U: Array) -> Array:
        """Upper bound of log peak less log limit `(n,)` at U `(n, 2)`: allowed where it is not above zero."""
        if self.learnt is None:
            return np.full(len(U), np.inf)
        mu, sigma = self.peak(U)
        return np.asarray(mu + self.z * sigma - self.log_limit)

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """The constraint `(n,)` and its gradient `(n, 2)`; needs at least one push."""
        assert self.learnt is not None
        v = self.speeds[0]
        mu, sigma, dmu, dsigma = self.learnt.gradient(U, self.trend.basis(len(U), v))
        total = np.hypot(sigma, self.noise)
        value = mu + self.trend.expected(U, v) + self.z * total - self.log_limit
        slope = dmu + self.z * (sigma / total)[:, None] * dsigma
        slope[:, 1] += self.trend.slope(U)
        return value, slope

    def allowed(self, U: Array) -> np.ndarray:
        """Which of pushes U `(n, 2)` are allowed: bool `(n,)`."""
        return np.asarray(self.constraint(U) <= BRINK)

    def probability(self, u: Array, v: float) -> float:
        """P(peak of push u `(2,)` at speed v (m/s) <= limit); nan before the first push."""
        if self.learnt is None:
            return float("nan")
        from scipy.special import ndtr

        mu, sigma = self.peak(u[None], v)
        return float(ndtr((self.log_limit - mu[0]) / sigma[0]))

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

    def walled(self, objective: Objective) -> Objective:
        """The objective with a wall about the allowed pushes, once there are any."""
        return objective if self.learnt is None else Walled(objective, self)

    def initial(self, u: Array, outer: Array) -> Choice:
        """The allowed push nearest to a point of the design `(2,)`."""
        return self._paced(*self.nearest(u, lambda U: np.sum((U - u) ** 2, axis=1), [outer]))

    def choose(
        self, u: Array, posterior: Posterior, objective: Objective, box: Array, outer: Array
    ) -> Choice:
        """Push u `(2,)`, or the allowed one of the lowest objective, as fast as is gentle enough.

        Where that is not expected to help, see `elsewhere`.
        """
        wanted, notes = self.nearest(u, objective.value, [box, outer])
        if posterior.expected(wanted)[0] >= 0.0:
            wanted, notes = self.elsewhere(wanted, notes, posterior.surface, outer)
        return self._paced(wanted, notes)

    def nearest(
        self, u: Array, cost: Callable[[Array], Array], boxes: list[Array]
    ) -> tuple[Array, dict[str, float]]:
        """A push in place of u `(2,)` if that is not allowed, and a note for the record.

        The allowed push of the lowest cost in the first of the `boxes` that holds any. Where nothing is known
        to be allowed, the gentlest: the shortest push, where the peak is expected lowest.
        """
        if self.allowed(u[None])[0]:
            return u, {}
        for box in boxes:
            grid = grid_over(box, *GRID)
            allowed = grid[self.allowed(grid)]
            if len(allowed):
                return allowed[lowest(cost(allowed))], {"held_back": 1.0}
        shortest = _shortest(boxes[-1])
        if self.learnt is None:
            return np.array([u[0], shortest[0, 1]]), {"no_safe_push": 1.0}
        # By what is expected, not by the bound: that would repeat the push that is known best for ever.
        return shortest[lowest(self.peak(shortest)[0])], {"no_safe_push": 1.0}

    def elsewhere(
        self, u: Array, notes: dict[str, float], xi: Surface, outer: Array
    ) -> tuple[Array, dict[str, float]]:
        """A short push that is expected to help, where no allowed one is; the given one if there is none.

        Without it the allowed set could end on one side of the object, and every push lead farther away. It
        is the most helpful of those that are expected to stay under the limit; if none of these helps, and
        none is allowed either, the most helpful of the gentlest that do: of those whose peaks differ by less
        than that of one push, repeated, would.
        """
        shortest, over = self.shortest(outer)
        mean, _ = xi.predict(shortest)
        helps = mean < 0.0
        gentle = helps & (over <= 0.0)
        if gentle.any():
            return shortest[lowest(np.where(gentle, mean, np.inf))], {"begun_elsewhere": 1.0}
        if helps.any() and "no_safe_push" in notes:
            gentlest = helps & (over <= over[helps].min() + self.noise)
            return shortest[lowest(np.where(gentlest, mean, np.inf))], notes
        return u, notes

    def shortest(self, box: Array) -> tuple[Array, Array]:
        """The shortest pushes `(n, 2)` of a box, and by how much log peak is expected over the limit `(n,)`.

        Expected, at the slowest speed, and not sure: what is known of other places does not reach them. As in
        SafeOpt, learning begins at pushes that are held to be safe beforehand; there are none gentler.
        """
        shortest = _shortest(box)
        if self.learnt is None:
            return shortest, np.zeros(len(shortest))
        return shortest, self.peak(shortest)[0] - self.log_limit

    def _paced(self, u: Array, notes: dict[str, float]) -> Choice:
        """Push u `(2,)`, as fast as is gentle enough, with the probability that it is."""
        v = self.fastest(u)
        safe = {"p_safe": self.probability(u, v)}
        return Choice(u, v if self.speeds[1] else None, notes | safe, anywhere=bool(notes))


def _shortest(box: Array) -> Array:
    """Pushes `(n, 2)` of the least d in a box."""
    grid = grid_over(box, *GRID)
    return np.asarray(grid[grid[:, 1] == grid[:, 1].min()])


@dataclass(frozen=True, eq=False)
class Walled:
    """An objective with a wall about the allowed pushes: a(u) + steep * max(0, constraint(u))."""

    inner: Objective
    safe_set: SafeSet
    steep: float = 100.0
    """Far above what an acquisition gains along the way, so that minima lie inside."""

    def value(self, U: Array) -> Array:
        """Values `(n,)` at U `(n, 2)`."""
        return np.asarray(self.inner.value(U) + self.steep * np.maximum(self.safe_set.constraint(U), 0.0))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)`."""
        value, slope = self.inner.gradient(U)
        constraint, by_u = self.safe_set.gradient(U)
        outside = constraint > 0.0
        wall = self.steep * np.where(outside, constraint, 0.0)
        return value + wall, slope + self.steep * np.where(outside[:, None], by_u, 0.0)
