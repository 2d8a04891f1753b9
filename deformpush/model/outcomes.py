"""Outcomes over (kappa, d) as the motion model has them, and what follows for xi."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from deformpush.gp.sample_path import SamplePath
from deformpush.model.base import Surface
from deformpush.model.coordinates import grid, share_of_longest
from deformpush.model.error_of_motion import ErrorOfMotion
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

    def draw(self, features: int, rng: np.random.Generator) -> "Level":
        """A constant: nothing is known of how it varies."""
        return Level(self.scale * float(rng.normal()))


@dataclass(frozen=True)
class Level:
    """A constant function."""

    level: float

    def value(self, U: Array) -> Array:
        """Values `(n,)`."""
        return np.full(len(U), self.level)

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)`."""
        return self.value(U), np.zeros((len(U), 2))


@dataclass(frozen=True, eq=False)
class OutcomeField:
    """Mean and standard deviation of the four outcomes over (kappa, d) in model coordinates."""

    surfaces: Sequence[Surface]
    """Posteriors of the outcomes, or of what the prior mean leaves of them."""
    prior: RigidField | None
    noise: Array
    """Standard deviations `(4,)` of what no model can tell, for the longest push."""
    d: Array
    """d_min, d_max (m)."""

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Means and standard deviations `(n, 4)` at U `(n, 2)`."""
        mean, std = (np.stack(x, axis=1) for x in zip(*(s.predict(U) for s in self.surfaces), strict=True))
        share = self.share(U)[:, None]
        mean *= share
        std *= share
        if self.prior is not None:
            mean[:, :3] += self.prior.at(U)[0]
        return mean, std

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """Means, standard deviations `(n, 4)` and their gradients `(n, 4, 2)`."""
        each = zip(*(s.gradient(U) for s in self.surfaces), strict=True)
        mean, std, by_mean, by_std = (np.stack(x, axis=1) for x in each)
        share = self.share(U)[:, None]
        for value, slope in ((mean, by_mean), (std, by_std)):
            slope *= share[:, None]
            slope[:, :, 1] += value * (1.0 - self.d[0] / self.d[1])
            value *= share
        if self.prior is not None:
            motion, slopes = self.prior.at(U)
            mean[:, :3] += motion
            by_mean[:, :3] += slopes
        return mean, std, by_mean, by_std

    def share(self, U: Array) -> Array:
        """Share of d_max `(n,)`: the processes learn outcomes per length, since short pushes do little."""
        return share_of_longest(U, self.d)

    def mean_grid(self, n_kappa: int = 16, n_d: int = 3) -> Array:
        """Mean outcomes `(K, 4)` over a grid of pushes."""
        return self.predict(grid(np.arange(n_kappa) / n_kappa, np.linspace(0.0, 1.0, n_d)))[0]


@dataclass(frozen=True, eq=False)
class MotionSurface:
    """mu and sigma of xi over u, through the outcomes and the error that follows from them."""

    outcomes: OutcomeField
    xi: ErrorOfMotion

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Mu and sigma `(n,)` at U `(n, 2)`."""
        change = self.xi.change(*self.outcomes.predict(U))
        return change.mu, change.sigma

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """mu, sigma `(n,)` and their gradients `(n, 2)`, by the chain rule."""
        mean, std, by_mean, by_std = self.outcomes.gradient(U)
        c = self.xi.gradient(mean, std)
        dmu = np.einsum("nj,njk->nk", c.mu_by_mean, by_mean) + np.einsum("nj,njk->nk", c.mu_by_std, by_std)
        dsigma = np.einsum("nj,njk->nk", c.sigma_by_mean, by_mean)
        dsigma += np.einsum("nj,njk->nk", c.sigma_by_std, by_std)
        return c.mu, c.sigma, dmu, dsigma

    def draw(self, features: int, rng: np.random.Generator) -> "MotionDraw":
        """One function drawn for each outcome, composed."""
        drawn = [Drawn(s.draw(features, rng)) for s in self.outcomes.surfaces]
        return MotionDraw(replace(self.outcomes, surfaces=drawn), self.xi)


@dataclass(frozen=True, eq=False)
class Drawn:
    """One function as a surface without uncertainty."""

    path: SamplePath

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and zeros."""
        value = self.path.value(U)
        return value, np.zeros_like(value)

    def draw(self, features: int, rng: np.random.Generator) -> SamplePath:
        """The function itself."""
        return self.path

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """Values `(n,)`, zeros, and their gradients `(n, 2)`."""
        value, slope = self.path.gradient(U)
        return value, np.zeros_like(value), slope, np.zeros_like(slope)


@dataclass(frozen=True, eq=False)
class MotionDraw:
    """xi of one draw of the outcomes."""

    outcomes: OutcomeField
    xi: ErrorOfMotion

    def value(self, U: Array) -> Array:
        """Values of xi `(n,)` at U `(n, 2)`."""
        return self.gradient(U)[0]

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values of xi `(n,)` and their gradient `(n, 2)`."""
        y, none, by_u, _ = self.outcomes.gradient(U)
        change = self.xi.gradient(y, none)
        return change.mu, np.einsum("nj,njk->nk", change.mu_by_mean, by_u)
