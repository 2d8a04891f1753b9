"""The motion model's posterior of the next push, and what it prefers where the best push would do harm."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from deformpush.mechanics.geometry import rotation
from deformpush.mechanics.rounding import lowest
from deformpush.model.coordinates import grid_over
from deformpush.model.error_of_motion import ErrorOfMotion, pose
from deformpush.model.outcomes import MotionSurface, OutcomeField
from deformpush.state import Forecast, State

Array = np.ndarray

GRID = (48, 6)
"""Pushes over (kappa, d) among which a better one is looked for."""


@dataclass(frozen=True, eq=False)
class MotionPosterior:
    """What the outcomes of the next push may be, and xi with them."""

    state: State
    outcomes: OutcomeField
    next_push: ErrorOfMotion
    planned: ErrorOfMotion
    """As far ahead as the model plans."""
    info: dict[str, float] = field(default_factory=dict)

    @cached_property
    def surface(self) -> MotionSurface:
        """What the acquisition is taken over."""
        return MotionSurface(self.outcomes, self.planned)

    def expected(self, u: Array) -> tuple[float, float]:
        """Mean and standard deviation of xi of the very next push u `(2,)`, however far was planned."""
        mu, sigma = MotionSurface(self.outcomes, self.next_push).predict(u[None])
        return float(mu[0]), float(sigma[0])

    def predictive(self, U: Array) -> tuple[Array, Array]:
        """Mean and standard deviation of xi `(n,)` of pushes U `(n, 2)`, noise of the outcomes included."""
        mean, variance = self._measured(U)
        change = self.next_push.change(mean, np.sqrt(variance))
        return change.mu, change.sigma

    def forecast(self, u: Array) -> Forecast:
        """Centroid, angle and shape error after push u `(2,)`, noise included."""
        mean, variance = (x[0] for x in self._measured(u[None]))
        turn = np.eye(4)
        turn[:2, :2] = rotation(self.state.seen.theta)
        after = pose(self.state) + turn @ mean
        return Forecast(after, turn @ np.diag(variance) @ turn.T)

    def _measured(self, U: Array) -> tuple[Array, Array]:
        """Means and variances `(n, 4)` of the outcomes of pushes U `(n, 2)`, noise included."""
        mean, std = self.outcomes.predict(U)
        noise = self.outcomes.noise * self.outcomes.share(U)[:, None]
        return mean, std**2 + noise**2

    def instead(self, u: Array, box: Array) -> tuple[Array | None, dict[str, float]]:
        """A better push in the box than u `(2,)` if that is expected to do harm, and why.

        Of a grid of pushes the one with the lowest expected error; if none of them is expected to help, the
        most informative one of those that may.
        """
        if float(self.surface.predict(u[None])[0][0]) < 0.0:
            return None, {}
        grid = grid_over(box, *GRID)
        mu, sigma = self.surface.predict(grid)
        if mu.min() < 0.0:
            return grid[lowest(mu)], {"harm_avoided": 1.0}
        told = np.where(mu - 2.0 * sigma < 0.0, information(self.outcomes, grid), -np.inf)
        # Where none may help, the one that comes nearest to it.
        best = lowest(-told) if np.isfinite(told).any() else lowest(mu - 2.0 * sigma)
        return grid[best], {"no_help_expected": 1.0}


def information(outcomes: OutcomeField, U: Array) -> Array:
    """I(u) = sum_j log(1 + sigma_j^2 / noise_j^2) / 2 (MacKay 1992): what pushes U would tell `(n,)`."""
    _, std = outcomes.predict(U)
    noise = np.maximum(outcomes.noise, 1e-9) * outcomes.share(U)[:, None]
    return np.asarray(0.5 * np.log1p((std / noise) ** 2).sum(axis=1))
