"""From how the object may move to how the error may change: eqs. (1)-(4) over Monte Carlo draws."""

from typing import NamedTuple

import numpy as np

from deformpush.model.normal_draws import normal_draws
from deformpush.state import State
from deformpush.task import SHAPE

Array = np.ndarray
Pose = tuple[Array, Array, Array, Array]
"""Centroid x, y (m), angle (rad), shape error (3), in one shape `(...)`."""

BLOCK = 16_384
"""So many numbers are worked on at once: what does not fit the cache takes three times as long."""


class Change(NamedTuple):
    """Mean and standard deviation of xi `(n,)`, and their derivatives `(n, 4)` where they were asked for."""

    mu: Array
    sigma: Array
    mu_by_mean: Array = np.empty(0)
    mu_by_std: Array = np.empty(0)
    sigma_by_mean: Array = np.empty(0)
    sigma_by_std: Array = np.empty(0)


class ErrorOfMotion:
    """xi = e_T(state moved by y) - e_T(state), y = mean + std z, the same normal draws z for every push.

    An outcome y is the displacement of the centroid in the object's frame (2, m), the turn (rad) and the
    change of the shape error (3).
    """

    def __init__(self, state: State, samples: int, ahead: Array | None = None) -> None:
        """For an object as `state` has it.

        Args:
            state: the object before the push.
            samples: number of draws; a scrambled Sobol sequence.
            ahead: mean outcomes `(K, 4)` of pushes that may follow, for looking two pushes ahead.
        """
        x, y, theta, shape = pose(state)
        self._pose, self._e_T = (x, y, theta, shape), state.total_error
        self.z = normal_draws(samples)
        self.ahead = ahead
        self.stay = float(self._cost(np.zeros((1, 1, 4)))[0, 0])

    def change(self, mean: Array, std: Array) -> Change:
        """Mean and spread of xi for pushes with these outcomes `(n, 4)`."""
        mu, sigma, _ = moments(self._cost(self._outcomes(mean, std)) - self.stay)
        return Change(mu, sigma)

    def gradient(self, mean: Array, std: Array) -> Change:
        """The same with derivatives."""
        cost, slope = self._slope(self._outcomes(mean, std))
        mu, sigma, off = moments(cost - self.stay)
        # Every draw of xi depends on its own draw of y alone.
        z = self.z[:, None]
        lean = (off / sigma)[..., None] * slope
        by = (slope, slope * z, lean, lean * z)
        return Change(mu, sigma, *(g.mean(axis=0) for g in by))

    def _outcomes(self, mean: Array, std: Array) -> Array:
        """Draws `(N, n, 4)` of the outcomes."""
        return mean + std * self.z[:, None]

    def _cost(self, y: Array) -> Array:
        """e_T `(N, n)` after outcomes `(N, n, 4)`; two pushes ahead: the mean of it and of the best after."""
        after = moved(self._pose, y)
        e_T: Array = self._e_T(*after)
        if self.ahead is None:
            return e_T
        best, _ = self._best_after(after, self.ahead)
        return 0.5 * (e_T + np.minimum(best, e_T))

    def _best_after(self, after: Pose, ahead: Array) -> tuple[Array, Array]:
        """Lowest e_T `(N, n)` that one of the pushes ahead leads to, and which of them does `(N, n)`."""
        x, y, theta, shape = (p.reshape(-1, 1) for p in after)
        best, which = np.empty(len(x)), np.empty(len(x), dtype=int)
        rows = max(1, BLOCK // len(ahead))
        for first in range(0, len(x), rows):
            part = slice(first, first + rows)
            e_T = self._e_T(*moved((x[part], y[part], theta[part], shape[part]), ahead))
            best[part], which[part] = e_T.min(axis=1), e_T.argmin(axis=1)
        return best.reshape(after[0].shape), which.reshape(after[0].shape)

    def _slope(self, y: Array) -> tuple[Array, Array]:
        """What `_cost` returns, and its derivatives `(N, n, 4)` by y."""
        after = moved(self._pose, y)
        cost, by_after = self._e_T.gradient(*after)
        if self.ahead is not None:
            chosen = self.ahead[self._best_after(after, self.ahead)[1]]
            then, by_then = self._e_T.gradient(*moved(after, chosen))
            goes_on = then < cost
            by_after = 0.5 * (by_after + np.where(goes_on, back_to_start(after, chosen, by_then), by_after))
            cost = 0.5 * (cost + np.where(goes_on, then, cost))
        return cost, back_to_outcome(self._pose, y, by_after)


def pose(state: State) -> Array:
    """Centroid x, y (m), angle (rad) and shape error (3) of the object `(4,)`: what an outcome changes."""
    return np.array([*state.seen.c, state.seen.theta, state.errors[SHAPE.symbol]])


def moments(xi: Array) -> tuple[Array, Array, Array]:
    """Mean and standard deviation `(n,)` over draws `(N, n)`, and the deviations of the draws."""
    mu = xi.mean(axis=0)
    off = xi - mu
    # Without the last term a push with certain effect would have no slope.
    return mu, np.sqrt((off * off).mean(axis=0) + 1e-16), off


def moved(start: Pose, y: Array) -> Pose:
    """Where outcomes y `(..., 4)` lead from a start."""
    x0, y0, theta, shape = start
    cos, sin = np.cos(theta), np.sin(theta)
    x = x0 + cos * y[..., 0] - sin * y[..., 1]
    return x, y0 + sin * y[..., 0] + cos * y[..., 1], theta + y[..., 2], np.maximum(shape + y[..., 3], 0.0)


def back_to_outcome(start: Pose, y: Array, slope: Array) -> Array:
    """The derivatives `(..., 4)` by the outcome y, from those `(4, ...)` by where it leads."""
    _, _, theta, shape = start
    cos, sin = np.cos(theta), np.sin(theta)
    by_x, by_y, by_theta, by_shape = slope
    open_ = shape + y[..., 3] >= 0.0
    return np.stack([cos * by_x + sin * by_y, cos * by_y - sin * by_x, by_theta, by_shape * open_], axis=-1)


def back_to_start(start: Pose, y: Array, slope: Array) -> Array:
    """The derivatives `(4, ...)` by the start, from those `(4, ...)` by where the outcome y leads."""
    _, _, theta, shape = start
    cos, sin = np.cos(theta), np.sin(theta)
    by_x, by_y, by_theta, by_shape = slope
    lever = by_y * (cos * y[..., 0] - sin * y[..., 1]) - by_x * (sin * y[..., 0] + cos * y[..., 1])
    return np.stack([by_x, by_y, by_theta + lever, by_shape * (shape + y[..., 3] >= 0.0)])
