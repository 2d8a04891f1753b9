"""Which pushes are gentle enough: a second Gaussian process, on the logarithm of the strain they cause."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from deformpush.gp.fit import Fit
from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Constant
from deformpush.gp.profiles import Array
from deformpush.gp.regression import Surface
from deformpush.gp.regressor import Regressor

MAX_FIT = 200
GRID = (64, 24)
"""Pushes over (kappa, d) among which an allowed one is looked for."""


@dataclass(frozen=True)
class Trend:
    """What is expected of the peak before any push: it grows with the distance as (d / d_max)^growth."""

    growth: float
    d: tuple[float, float]
    """d_min, d_max (m)."""

    def __call__(self, U: Array) -> Array:
        """Log (d / d_max)^growth `(n,)` at U `(n, 2)` in model coordinates."""
        lo, hi = self.d
        return np.asarray(self.growth * np.log((lo + U[:, 1] * (hi - lo)) / hi))

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

    def excess(self, U: Array) -> Array:
        """Upper bound of log peak less log limit `(n,)` at U `(n, 2)`: allowed where it is not above zero."""
        if self.surface is None:
            return np.full(len(U), np.inf)
        mu, sigma = self.surface.predict(U)
        return np.asarray(mu + self.trend(U) + self.z * np.hypot(sigma, self.noise) - self.log_limit)

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """The excess `(n,)` and its gradient `(n, 2)`; needs at least one push."""
        assert self.surface is not None
        mu, sigma, dmu, dsigma = self.surface.gradient(U)
        total = np.hypot(sigma, self.noise)
        value = mu + self.trend(U) + self.z * total - self.log_limit
        slope = dmu + self.z * (sigma / total)[:, None] * dsigma
        slope[:, 1] += self.trend.slope(U)
        return value, slope

    def probability(self, u: Array) -> float:
        """P(peak of push u `(2,)` <= limit); nan before the first push."""
        if self.surface is None:
            return float("nan")
        from scipy.special import ndtr

        mu, sigma = self.surface.predict(u[None])
        total = float(np.hypot(sigma[0], self.noise))
        return float(ndtr((self.log_limit - mu[0] - self.trend(u[None])[0]) / total))

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
        grid = _grid(boxes[-1])
        shortest = grid[grid[:, 1] == grid[:, 1].min()]
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
        trend: Trend,
    ) -> None:
        """Nothing is known yet.

        Args:
            measure: the peak of a push, from the states before and after it.
            kernel: over (kappa, d, t), with `kappa` resolved.
            fit: learns its hyper-parameters.
            limit: what the peak must not exceed.
            z: quantile of the probability that is asked for.
            scale: by how much log peak may differ between pushes, beside the trend.
            trend: expected before any push.
        """
        self._measure, self._scale, self._trend = measure, scale, trend
        self._limit, self._z = limit, z
        self._gp = Regressor(kernel, Constant(3.0), fit, MAX_FIT)
        self.peaks = np.empty(0)
        """Measured so far `(S,)`."""

    def observe(self, before: Any | None, after: Any | None) -> float:
        """The peak of a push; changes nothing.

        Raises:
            ValueError: it was not measured.
        """
        if before is None or after is None:
            raise ValueError("tell: safe_lcb learns from states, call tell(u, xi, before, after)")
        peak = self._measure(before, after)
        if not (np.isfinite(peak) and peak >= 0.0):
            raise ValueError(f"tell: the peak of the push is {peak}, safe_lcb needs a measured one")
        return peak

    def keep(self, peak: float) -> None:
        """Append what `observe` returned."""
        self.peaks = np.append(self.peaks, peak)

    def allowance(self, U: Array) -> Allowance:
        """What is allowed next, after pushes U `(S, 2)` in model coordinates, oldest first."""
        S, log_limit = len(U), float(np.log(self._limit))
        if not S:
            return Allowance(None, 0.0, self._trend, log_limit, self._z)
        # A push that strains nothing says as little as one at a thousandth of the limit.
        y = np.log(np.maximum(self.peaks, 1e-3 * self._limit)) - self._trend(U)
        X = np.column_stack([U, np.arange(S, dtype=float)])
        posterior, info = self._gp.condition(X, y, self._scale, float(S))
        noise = info["noise"] * self._scale
        return Allowance(posterior.at(float(S)), noise, self._trend, log_limit, self._z)

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""
        theta = np.full(5, np.nan) if self._gp.theta is None else self._gp.theta.copy()
        return {"guard_peaks": self.peaks.copy(), "guard_theta": theta, "guard_fitted": self._gp.fitted}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""
        self.peaks = np.array(state["guard_peaks"], float)
        theta = np.array(state["guard_theta"], float)
        self._gp.theta = None if np.isnan(theta).any() else theta
        self._gp.fitted = int(state["guard_fitted"])


def _grid(box: Array) -> Array:
    """Pushes `(n, 2)` over box `[[lo, hi], [lo, hi]]`, its sides included."""
    kappa, d = np.meshgrid(*(np.linspace(lo, hi, n) for (lo, hi), n in zip(box, GRID, strict=True)))
    return np.column_stack([kappa.ravel(), d.ravel()])
