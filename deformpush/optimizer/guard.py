"""Which pushes are gentle enough: a second Gaussian process, on the logarithm of the strain they cause."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from deformpush.gp.fit import Fit
from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Constant
from deformpush.gp.profiles import Array
from deformpush.gp.regression import Surface
from deformpush.gp.regressor import Regressor

MAX_FIT = 200
FASTER = 1.5
"""Of the fastest push so far: how fast the next may be."""
SCATTER = 0.5
"""Of log peak about its trend, in units of its scale, when v_0 is learnt."""
DOUBT = 0.5
"""Standard deviation of log v_0 before any push."""
GRID = (64, 24)
"""Pushes over (kappa, d) among which an allowed one is looked for."""


@dataclass(frozen=True)
class Trend:
    """What is expected of the peak before any push: (d / d_max)^growth (1 + (v / v_0)^2).

    The first factor says that it grows with the distance. The second is the impact: bringing the object to
    the tool's speed v costs a force beside that of friction, which grows with v^2 for a tool that meets it in
    motion. v_0, the speed at which the two are alike, is learnt.
    """

    growth: float
    d: tuple[float, float]
    """d_min, d_max (m)."""
    v_0: float
    """m/s."""

    def __call__(self, U: Array, v: Any = 0.0) -> Array:
        """Its logarithm `(n,)` at U `(n, 2)` in model coordinates, at speed v (m/s)."""
        lo, hi = self.d
        return np.asarray(
            self.growth * np.log((lo + U[:, 1] * (hi - lo)) / hi) + np.log1p((v / self.v_0) ** 2)
        )

    def slope(self, U: Array) -> Array:
        """Its derivative by the second coordinate `(n,)`."""
        lo, hi = self.d
        return np.asarray(self.growth * (hi - lo) / (lo + U[:, 1] * (hi - lo)))


@dataclass(frozen=True, eq=False)
class Allowance:
    """Where the probability that the peak of the next push stays under the limit is p_safe or more."""

    surface: Surface | None
    """Of log peak less its trend, in units of 1; None before the first push."""
    noise: float
    """Standard deviation of what a repeated push would give."""
    trend: Trend
    log_limit: float
    z: float
    """The quantile of p_safe."""
    speeds: tuple[float, float]
    """Slowest and fastest (m/s) that may be chosen now; alike where the speed is not free."""

    def excess(self, U: Array, v: float | None = None) -> Array:
        """Upper bound of log peak less log limit `(n,)` at U `(n, 2)`: allowed where it is not above zero.

        `v` is the speed (m/s), by default the slowest: a push is allowed if it is at any speed.
        """
        if self.surface is None:
            return np.full(len(U), np.inf)
        mu, sigma = self.surface.predict(U)
        trend = self.trend(U, self.speeds[0] if v is None else v)
        return np.asarray(mu + trend + self.z * np.hypot(sigma, self.noise) - self.log_limit)

    def fastest(self, u: Array) -> float:
        """The highest speed (m/s) at which push u `(2,)` is allowed, the slowest if it is at none."""
        slow, fast = self.speeds
        if self.excess(u[None], fast)[0] <= 0.0:
            return fast
        # In closed form: log(1 + (v / v_0)^2) may take up what the slowest push leaves below the limit.
        room = np.log1p((slow / self.trend.v_0) ** 2) - float(self.excess(u[None], slow)[0])
        return float(np.clip(self.trend.v_0 * np.sqrt(max(np.expm1(room), 0.0)), slow, fast))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """The excess `(n,)` and its gradient `(n, 2)`; needs at least one push."""
        assert self.surface is not None
        mu, sigma, dmu, dsigma = self.surface.gradient(U)
        total = np.hypot(sigma, self.noise)
        value = mu + self.trend(U, self.speeds[0]) + self.z * total - self.log_limit
        slope = dmu + self.z * (sigma / total)[:, None] * dsigma
        slope[:, 1] += self.trend.slope(U)
        return value, slope

    def probability(self, u: Array, v: float) -> float:
        """P(peak of push u `(2,)` at speed v (m/s) <= limit); nan before the first push."""
        if self.surface is None:
            return float("nan")
        from scipy.special import ndtr

        mu, sigma = self.surface.predict(u[None])
        total = float(np.hypot(sigma[0], self.noise))
        return float(ndtr((self.log_limit - mu[0] - self.trend(u[None], v)[0]) / total))

    def gentlest(self, box: Array) -> Array:
        """The shortest pushes `(n, 2)` of a box whose peak at the slowest speed is expected under the limit.

        Expected, not sure: what is known of other places does not reach them. As in SafeOpt, learning begins
        at pushes that are held to be safe beforehand, and these are the gentlest there are.
        """
        shortest = _shortest(box)
        if self.surface is None:
            return shortest
        expected = self.surface.predict(shortest)[0] + self.trend(shortest, self.speeds[0])
        return shortest[expected <= self.log_limit]

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
        if self.surface is None:
            return np.array([u[0], shortest[0, 1]]), {"no_safe_push": 1.0}
        # By what is expected, not by the bound: that would repeat the push that is known best for ever.
        return shortest[np.argmin(self.surface.predict(shortest)[0])], {"no_safe_push": 1.0}


class Guard:
    """Learns log peak over (kappa, d, t) from what was measured of each push."""

    def __init__(
        self,
        measure: Callable[[Any, Any], float],
        kernel: Kernel,
        fit: Fit,
        *,
        limit: float,
        z: float,
        scale: float,
        scatter: float,
        trend: Trend,
        speeds: tuple[float, float] | None,
    ) -> None:
        """Nothing is known yet.

        Args:
            measure: the peak of a push, from the states before and after it.
            kernel: over (kappa, d, t), with `kappa` resolved.
            fit: learns its hyper-parameters.
            limit: what the peak must not exceed.
            z: quantile of the probability that is asked for.
            scale: by how much log peak may differ between pushes, beside the trend.
            scatter: standard deviation of log peak about what is measured, where that is something else.
            trend: expected before any push.
            speeds: slowest and fastest that may be chosen (m/s); None: the speed is not free.
        """
        self._measure, self._scale, self._scatter, self._trend = measure, scale, scatter, trend
        self._limit, self._z, self._free = limit, z, speeds
        self._gp = Regressor(kernel, Constant(3.0), fit, MAX_FIT)
        self.peaks = np.empty(0)
        """Measured so far `(S,)`."""
        self.speeds = np.empty(0)
        """At which (m/s) `(S,)`; 0 where the speed is not free."""

    def observe(self, before: Any | None, after: Any | None) -> tuple[float, float]:
        """Peak and speed of a push; changes nothing.

        Raises:
            ValueError: it was not measured.
        """
        if before is None or after is None:
            raise ValueError("tell: safe_lcb learns from states, call tell(u, xi, before, after)")
        peak = self._measure(before, after)
        if not (np.isfinite(peak) and peak >= 0.0):
            raise ValueError(f"tell: the peak of the push is {peak}, safe_lcb needs a measured one")
        if self._free is None:
            return peak, 0.0
        speed = float(after.speed)
        return peak, self._free[1] if np.isnan(speed) else speed

    def keep(self, observed: tuple[float, float]) -> None:
        """Append what `observe` returned."""
        self.peaks, self.speeds = np.append(self.peaks, observed[0]), np.append(self.speeds, observed[1])

    def allowance(self, U: Array) -> Allowance:
        """What is allowed next, after pushes U `(S, 2)` in model coordinates, oldest first."""
        S, log_limit = len(U), float(np.log(self._limit))
        if not S:
            return Allowance(None, 0.0, self._trend, log_limit, self._z, self._speeds_now())
        # A push that strains nothing says as little as one at a thousandth of the limit.
        y = np.log(np.maximum(self.peaks, 1e-3 * self._limit))
        trend = self._impact(y, U)
        y = y - trend(U, self.speeds)
        X = np.column_stack([U, np.arange(S, dtype=float)])
        posterior, info = self._gp.condition(X, y, self._scale, float(S))
        noise = float(np.hypot(info["noise"] * self._scale, self._scatter))
        return Allowance(posterior.at(float(S)), noise, trend, log_limit, self._z, self._speeds_now())

    def _speeds_now(self) -> tuple[float, float]:
        """The speeds that may be chosen next: at first the slowest, then little by little faster ones."""
        if self._free is None:
            return 0.0, 0.0
        slow, fast = self._free
        return slow, min(fast, FASTER * float(self.speeds.max())) if len(self.speeds) else slow

    def _impact(self, y: Array, U: Array) -> Trend:
        """The trend with the v_0 that fits log peaks y `(S,)` best, no farther from its prior than pays."""
        if self._free is None:
            return self._trend

        def cost(trend: Trend) -> float:
            rest = y - trend(U, self.speeds)
            fit = np.sum((rest - rest.mean()) ** 2) / (2.0 * (SCATTER * self._scale) ** 2)
            return float(fit + np.log(trend.v_0 / self._trend.v_0) ** 2 / (2.0 * DOUBT**2))

        tried = self._trend.v_0 * np.exp(np.linspace(-1.5, 1.5, 31))
        return min((replace(self._trend, v_0=float(v_0)) for v_0 in tried), key=cost)

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""
        theta = np.full(5, np.nan) if self._gp.theta is None else self._gp.theta.copy()
        return {
            "guard_peaks": self.peaks.copy(),
            "guard_speeds": self.speeds.copy(),
            "guard_theta": theta,
            "guard_fitted": self._gp.fitted,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""
        self.peaks = np.array(state["guard_peaks"], float)
        self.speeds = np.array(state["guard_speeds"], float)
        theta = np.array(state["guard_theta"], float)
        self._gp.theta = None if np.isnan(theta).any() else theta
        self._gp.fitted = int(state["guard_fitted"])


def _grid(box: Array) -> Array:
    """Pushes `(n, 2)` over box `[[lo, hi], [lo, hi]]`, its sides included."""
    kappa, d = np.meshgrid(*(np.linspace(lo, hi, n) for (lo, hi), n in zip(box, GRID, strict=True)))
    return np.column_stack([kappa.ravel(), d.ravel()])


def _shortest(box: Array) -> Array:
    """Of those, the pushes of the least d."""
    grid = _grid(box)
    return np.asarray(grid[grid[:, 1] == grid[:, 1].min()])
