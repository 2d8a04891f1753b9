"""What the motion model believes of the next push, and what it prefers where the best push would do harm."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from deformpush.contour import rotation
from deformpush.model.composition import Composition
from deformpush.model.outcomes import MotionSurface, OutcomeField

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Mean:
    """The objective u -> mu(u)."""

    surface: MotionSurface

    def value(self, U: Array) -> Array:
        """Values `(n,)`."""
        return self.surface.predict(U)[0]

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)`."""
        mu, _, dmu, _ = self.surface.gradient(U)
        return mu, dmu


@dataclass(frozen=True, eq=False)
class Information:
    """-I(u) where u may help, I = sum_j log(1 + sigma_j^2 / noise_j^2) / 2 (MacKay 1992): what u would tell.

    A push may help if mu - 2 sigma of its xi is below 0. Where none may, `beyond` times that bound is added:
    the less hopeless the better.
    """

    surface: MotionSurface
    beyond: float = 1e3

    def value(self, U: Array) -> Array:
        """Values `(n,)`."""
        mu, sigma = self.surface.predict(U)
        _, std = self.surface.outcomes.predict(U)
        told = 0.5 * np.log1p((std / self._noise(U)) ** 2).sum(axis=1)
        return np.asarray(self.beyond * np.maximum(mu - 2.0 * sigma, 0.0) - told)

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)`."""
        mu, sigma, dmu, dsigma = self.surface.gradient(U)
        _, std, _, by_std = self.surface.outcomes.gradient(U)
        noise = self._noise(U)
        bound = mu - 2.0 * sigma
        value = self.beyond * np.maximum(bound, 0.0) - 0.5 * np.log1p((std / noise) ** 2).sum(axis=1)
        # Noise grows with d as std does, and what is told depends on their ratio.
        share = self.surface.outcomes.share(U)[:, None]
        rise = by_std.copy()
        rise[:, :, 1] -= std / share * (1.0 - self.surface.outcomes.d[0] / self.surface.outcomes.d[1])
        slope = -np.einsum("nj,njk->nk", std / (std**2 + noise**2), rise)
        return value, slope + np.where(bound > 0, self.beyond, 0.0)[:, None] * (dmu - 2.0 * dsigma)

    def _noise(self, U: Array) -> Array:
        outcomes = self.surface.outcomes
        return np.maximum(outcomes.noise, 1e-9) * outcomes.share(U)[:, None]


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

    def instead(self, u: Array, search: Callable[[Any], Any]) -> tuple[Any | None, dict[str, float]]:
        """A better push than u `(2,)` if that is expected to do harm, and why.

        The one with the lowest expected error; if even that one would not help, the most informative one of
        those that may.
        """
        if float(self.surface.predict(u[None])[0][0]) < 0.0:
            return None, {}
        lowest = search(Mean(self.surface))
        if lowest.value < 0.0:
            return lowest, {"harm_avoided": 1.0}
        return search(Information(self.surface)), {"no_help_expected": 1.0}
