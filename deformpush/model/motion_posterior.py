"""What the motion model believes of the next push, and what it prefers where the best push would do harm."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from deformpush.mechanics.geometry import rotation
from deformpush.model.error_of_motion import Composition
from deformpush.model.outcomes import MotionSurface, OutcomeField

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class MotionBelief:
    """What is believed of the next push."""

    state: Any
    outcomes: OutcomeField
    next_push: Composition
    planned: Composition
    """As far ahead as the model plans."""
    info: dict[str, float] = field(default_factory=dict)

    @property
    def surface(self) -> MotionSurface:
        """What the acquisition is taken over."""
        return MotionSurface(self.outcomes, self.planned)

    def expected(self, u: Array) -> tuple[float, float]:
        """Mean and standard deviation of xi of the very next push u `(2,)`, however far was planned."""
        mu, sigma = MotionSurface(self.outcomes, self.next_push).predict(u[None])
        return float(mu[0]), float(sigma[0])

    def forecast(self, u: Array) -> tuple[Array, Array]:
        """Mean `(4,)` and covariance `(4, 4)` of centroid, angle and e_gamma after u, noise included."""
        mean, std = (x[0] for x in self.outcomes.predict(u[None]))
        noise = self.outcomes.noise * self.outcomes.share(u[None])
        s = self.state
        turn = np.eye(4)
        turn[:2, :2] = rotation(s.theta)
        after = np.array([*s.c, s.theta, s.e_gamma]) + turn @ mean
        return after, turn @ np.diag(std**2 + noise**2) @ turn.T

    def instead(self, u: Array, box: Array) -> tuple[Array | None, dict[str, float]]:
        """A better push in the box than u `(2,)` if that is expected to do harm, and why.

        Of a grid of pushes the one with the lowest expected error; if none of them is expected to help, the
        most informative one of those that may.
        """
        if float(self.surface.predict(u[None])[0][0]) < 0.0:
            return None, {}
        grid = pushes(box)
        mu, sigma = self.surface.predict(grid)
        if mu.min() < 0.0:
            return grid[np.argmin(mu)], {"harm_avoided": 1.0}
        told = np.where(mu - 2.0 * sigma < 0.0, information(self.outcomes, grid), -np.inf)
        # Where none may help, the one that comes nearest to it.
        best = np.argmax(told) if np.isfinite(told).any() else np.argmin(mu - 2.0 * sigma)
        return grid[best], {"no_help_expected": 1.0}


def information(outcomes: OutcomeField, U: Array) -> Array:
    """I(u) = sum_j log(1 + sigma_j^2 / noise_j^2) / 2 (MacKay 1992): what pushes U would tell `(n,)`."""
    _, std = outcomes.predict(U)
    noise = np.maximum(outcomes.noise, 1e-9) * outcomes.share(U)[:, None]
    return np.asarray(0.5 * np.log1p((std / noise) ** 2).sum(axis=1))


def pushes(box: Array, n_kappa: int = 48, n_d: int = 6) -> Array:
    """A grid of pushes `(n, 2)` over box `[[lo, hi], [lo, hi]]`, its sides included."""
    (kappa_lo, kappa_hi), (d_lo, d_hi) = box
    kappa, d = np.meshgrid(np.linspace(kappa_lo, kappa_hi, n_kappa), np.linspace(d_lo, d_hi, n_d))
    return np.column_stack([kappa.ravel(), d.ravel()])
