"""What the motion model believes: outcomes over (kappa, d), and what follows for xi."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from deformpush.contour import rotation
from deformpush.model.composition import Change, Composition
from deformpush.model.rigid_push import RigidField

Array = np.ndarray


@dataclass(frozen=True)
class Unlearnt:
    """The prior of one outcome before any push: zero, with this standard deviation everywhere."""

    scale: float

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Mu and sigma `(n,)` at U `(n, 2)`."""
        return np.zeros(len(U)), np.full(len(U), self.scale)

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """mu, sigma `(n,)` and their gradients `(n, 2)`."""
        return *self.predict(U), np.zeros((len(U), 2)), np.zeros((len(U), 2))

    def draw(self, time: float, features: int, rng: np.random.Generator) -> "Level":
        """A constant: nothing is known of how it varies."""
        return Level(self.scale * float(rng.normal()))


@dataclass(frozen=True)
class Level:
    """A constant function."""

    level: float

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)`."""
        return np.full(len(U), self.level), np.zeros((len(U), 2))


@dataclass(frozen=True, eq=False)
class OutcomeField:
    """Mean and standard deviation of the four outcomes over (kappa, d) in model coordinates."""

    surfaces: list[Any]
    """Posteriors of the outcomes, or of what the prior mean leaves of them."""
    prior: RigidField | None
    noise: Array
    """Standard deviations `(4,)` of what no model can tell."""

    NAMES: ClassVar = ("dx", "dy", "dtheta", "de_gamma")

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Means and standard deviations `(n, 4)` at U `(n, 2)`."""
        mean, std = (np.stack(x, axis=1) for x in zip(*(s.predict(U) for s in self.surfaces), strict=True))
        if self.prior is not None:
            mean[:, :3] += self.prior.at(U)[0]
        return mean, std

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """Means, standard deviations `(n, 4)` and their gradients `(n, 4, 2)`."""
        each = zip(*(s.gradient(U) for s in self.surfaces), strict=True)
        mean, std, by_mean, by_std = (np.stack(x, axis=1) for x in each)
        if self.prior is not None:
            motion, slopes = self.prior.at(U)
            mean[:, :3] += motion
            by_mean[:, :3] += slopes
        return mean, std, by_mean, by_std

    def mean_grid(self, n_kappa: int = 24, n_d: int = 3) -> Array:
        """Mean outcomes `(K, 4)` over a grid of pushes."""
        kappa, d = np.meshgrid(np.arange(n_kappa) / n_kappa, np.linspace(0.0, 1.0, n_d))
        return self.predict(np.column_stack([kappa.ravel(), d.ravel()]))[0]


@dataclass(frozen=True, eq=False)
class MotionSurface:
    """mu and sigma of xi over u, through outcomes and composition."""

    outcomes: OutcomeField
    composition: Composition

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Mu and sigma `(n,)` at U `(n, 2)`."""
        change = self.composition.change(*self.outcomes.predict(U))
        return change.mu, change.sigma

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """mu, sigma `(n,)` and their gradients `(n, 2)`, by the chain rule."""
        mean, std, by_mean, by_std = self.outcomes.gradient(U)
        c: Change = self.composition.gradient(mean, std)
        dmu = np.einsum("nj,njk->nk", c.mu_by_mean, by_mean) + np.einsum("nj,njk->nk", c.mu_by_std, by_std)
        dsigma = np.einsum("nj,njk->nk", c.sigma_by_mean, by_mean)
        dsigma += np.einsum("nj,njk->nk", c.sigma_by_std, by_std)
        return c.mu, c.sigma, dmu, dsigma

    def draw(self, time: float, features: int, rng: np.random.Generator) -> "MotionDraw":
        """One function drawn for each outcome, composed."""
        paths = [s.draw(time, features, rng) for s in self.outcomes.surfaces]
        return MotionDraw(paths, self.outcomes.prior, self.composition)


@dataclass(frozen=True, eq=False)
class MotionDraw:
    """xi of one draw of the outcomes."""

    paths: list[Any]
    prior: RigidField | None
    composition: Composition

    def value(self, U: Array) -> Array:
        """Xi `(n,)` at U `(n, 2)`."""
        return self.gradient(U)[0]

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Xi `(n,)` and its gradient `(n, 2)`."""
        values, slopes = zip(*(path.gradient(U) for path in self.paths), strict=True)
        y, by_u = np.stack(values, axis=1), np.stack(slopes, axis=1)
        if self.prior is not None:
            motion, steep = self.prior.at(U)
            y[:, :3] += motion
            by_u[:, :3] += steep
        change = self.composition.gradient(y, np.zeros_like(y))
        return change.mu, np.einsum("nj,njk->nk", change.mu_by_mean, by_u)


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
    """-I(u), I = sum_j log(1 + sigma_j^2 / noise_j^2) / 2: what u would tell (MacKay 1992)."""

    outcomes: OutcomeField

    def value(self, U: Array) -> Array:
        """Values `(n,)`."""
        _, std = self.outcomes.predict(U)
        return np.asarray(-0.5 * np.log1p((std / self._noise) ** 2).sum(axis=1))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)`."""
        _, std, _, by_std = self.outcomes.gradient(U)
        value = -0.5 * np.log1p((std / self._noise) ** 2).sum(axis=1)
        return value, -np.einsum("nj,njk->nk", std / (std**2 + self._noise**2), by_std)

    @property
    def _noise(self) -> Array:
        return np.maximum(self.outcomes.noise, 1e-9)


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
        s = self.state
        turn = np.eye(4)
        turn[:2, :2] = rotation(s.theta)
        after = np.array([*s.c, s.theta, s.e_gamma]) + turn @ mean
        return after, turn @ np.diag(std**2 + self.outcomes.noise**2) @ turn.T

    def instead(self, u: Array, search: Callable[[Any], Any]) -> tuple[Any | None, dict[str, float]]:
        """A better push than u `(2,)` if that is expected to do harm, and why.

        The one with the lowest expected error; if even that one would not help, the most informative one.
        """
        if float(self.surface.predict(u[None])[0][0]) < 0.0:
            return None, {}
        lowest = search(Mean(self.surface))
        if lowest.value < 0.0:
            return lowest, {"harm_avoided": 1.0}
        return search(Information(self.outcomes)), {"no_help_expected": 1.0}
