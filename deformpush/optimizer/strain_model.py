"""What learns how much pushes strain: a second Gaussian process, on the logarithm of the peak."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from deformpush.gp.fit import Fit
from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Constant
from deformpush.gp.profiles import Array
from deformpush.gp.regressor import Regressor
from deformpush.gp.trend import TrendPosterior
from deformpush.optimizer.safe_set import SafeSet
from deformpush.optimizer.strain_trend import StrainTrend
from deformpush.state import State

FASTER = 1.5
"""Of the fastest push so far: how fast the next may be."""
LEVEL = 3.0
"""Standard deviation of log peak over all pushes about log limit, in units of its scale, before any push."""


class StrainModel:
    """Learns log peak over (kappa, d, t) from what was measured of each push."""

    def __init__(
        self,
        measure: Callable[[State, State], float],
        kernel: Kernel,
        fit: Fit,
        *,
        limit: float,
        z: float,
        z_speed: float,
        scale: float,
        scatter: float,
        trend: StrainTrend,
        speeds: tuple[float, float] | None,
    ) -> None:
        """Nothing is known yet.

        Args:
            measure: the peak of a push, from the states before and after it.
            kernel: over (kappa, d, t), with `kappa` resolved.
            fit: learns its hyper-parameters.
            limit: what the peak must not exceed.
            z: quantile of the probability that is asked for.
            z_speed: the same for going faster than the slowest.
            scale: by how much log peak may differ between pushes, beside the trend.
            scatter: standard deviation of log peak about what is measured, where that is something else.
            trend: expected before any push.
            speeds: slowest and fastest that may be chosen (m/s); None: the speed is not free.
        """
        self._measure, self._scale, self._scatter, self._trend = measure, scale, scatter, trend
        self._limit, self._z, self._z_speed, self._free = limit, z, z_speed, speeds
        self._gp = Regressor(kernel, Constant(LEVEL), fit)
        self.peaks = np.empty(0)
        """Measured so far `(S,)`."""
        self.speeds = np.empty(0)
        """At which (m/s) `(S,)`; 0 where the speed is not free."""

    def observe(self, before: State | None, after: State | None) -> tuple[float, float]:
        """Peak and speed of a push; changes nothing.

        Raises:
            ValueError: it was not measured.
        """
        if before is None or after is None:
            raise ValueError("tell: a safe acquisition learns from states, call tell(u, xi, before, after)")
        peak = self._measure(before, after)
        if not (np.isfinite(peak) and peak >= 0.0):
            raise ValueError(f"tell: the peak of the push is {peak}, a safe acquisition needs a measured one")
        if self._free is None:
            return peak, 0.0
        return peak, self._free[1] if after.speed is None else after.speed

    def keep(self, observed: tuple[float, float]) -> None:
        """Append what `observe` returned."""
        self.peaks, self.speeds = np.append(self.peaks, observed[0]), np.append(self.speeds, observed[1])

    def feasible(self, U: Array) -> SafeSet:
        """What is allowed next, after pushes U `(S, 2)` in model coordinates, oldest first."""
        S = len(U)
        if not S:
            return self._safe_set(None, 0.0)
        # A push that strains nothing says as little as one at a thousandth of the limit.
        y = np.log(np.maximum(self.peaks, 1e-3 * self._limit)) - self._trend.expected(U, self.speeds)
        X = np.column_stack([U, np.arange(S, dtype=float)])
        posterior, info = self._gp.condition(X, y, self._scale, float(S))
        kept = posterior.X[:, 2].astype(int)
        H = self._trend.basis(S, self.speeds)
        learnt = TrendPosterior(posterior, float(S), H[kept], y[kept], self._trend.spread)
        # What the camera does not tell is part of what repeated pushes scatter by, so they are not added up.
        noise = max(info["noise"] * self._scale, self._scatter)
        return self._safe_set(learnt, noise)

    def _safe_set(self, learnt: TrendPosterior | None, noise: float) -> SafeSet:
        limit = float(np.log(self._limit))
        return SafeSet(learnt, noise, self._trend, limit, self._z, self._z_speed, self._speeds_now())

    def _speeds_now(self) -> tuple[float, float]:
        """The speeds that may be chosen next: at first the slowest, then little by little faster ones."""
        if self._free is None:
            return 0.0, 0.0
        slow, fast = self._free
        return slow, min(fast, FASTER * float(self.speeds.max())) if len(self.speeds) else slow

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""
        theta, fitted = self._gp.state()
        return {
            "strain_peaks": self.peaks.copy(),
            "strain_speeds": self.speeds.copy(),
            "strain_theta": theta,
            "strain_fitted": fitted,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""
        self.peaks = np.array(state["strain_peaks"], float)
        self.speeds = np.array(state["strain_speeds"], float)
        self._gp.restore(state["strain_theta"], state["strain_fitted"])
