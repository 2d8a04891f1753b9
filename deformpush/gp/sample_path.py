"""One function drawn from the posterior, as a formula that can be evaluated and differentiated anywhere."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from deformpush.gp.cross_covariance import CrossCovariance
from deformpush.gp.kernel import Kernel
from deformpush.gp.profiles import Array

if TYPE_CHECKING:
    from deformpush.gp.regression import TimeSlice

JITTER = 1e-8
"""Added to the covariance of a grid, as a multiple of k(x, x): neighbouring points are nearly alike."""


class SamplePath(Protocol):
    """A function of u = (kappa, d) in units of xi."""

    def value(self, U: Array) -> Array:
        """Values `(n,)` at U `(n, 2)`."""

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)` at U `(n, 2)`."""


@dataclass(frozen=True, eq=False)
class SpectralPath:
    """f = mu_0 + f_0 + k^T K^-1 (y - mu_0 - f_0(X) - noise), f_0 a prior draw (Wilson et al. 2020)."""

    kernel: Kernel
    k_s: CrossCovariance
    level: float
    """mu_0 of the scaled xi."""
    scale: float
    time: float
    omega: Array
    """Frequencies `(F, E)` of the features cos(omega . embedded x + b)."""
    b: Array
    amplitude: float
    alpha: Array
    """sigma_f^2 k_t K^-1 (...) `(S,)`."""

    @classmethod
    def of(cls, now: "TimeSlice", features: int, rng: np.random.Generator) -> "SpectralPath":
        """Draw from the posterior at one time, with so many random Fourier features."""
        p = now.posterior
        omega = p.kernel.frequencies(p.theta, features, rng)
        b = rng.uniform(0.0, 2.0 * np.pi, features)
        amplitude = float(np.sqrt(2.0 * p.kernel.prior_variance(p.theta) / features))
        prior = amplitude * np.cos(p.kernel.embed(p.X) @ omega.T + b).sum(axis=1)
        noise = np.exp(p.theta[4]) * rng.normal(size=len(p.X))
        # y = mu_0 + K alpha, and K^-1 = root^T root: the data enter through alpha alone.
        alpha = now.amplitude * (p.alpha - p.root.T @ (p.root @ (prior + noise)))
        return cls(p.kernel, now.k_s, p.level, p.scale, now.t, omega, b, amplitude, alpha)

    def value(self, U: Array) -> Array:
        """F `(n,)` at U `(n, 2)`, in units of xi."""
        prior = self.amplitude * np.cos(self._phase(U)).sum(axis=1)
        return np.asarray(self.scale * (self.level + prior + self.k_s(U) @ self.alpha))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """F `(n,)` and its gradient `(n, 2)` at U `(n, 2)`."""
        phase = self._phase(U)
        k, dk = self.k_s.gradient(U)
        value = self.level + self.amplitude * np.cos(phase).sum(axis=1) + k @ self.alpha
        by_embedding = -self.amplitude * np.sin(phase) @ self.omega
        gradient = self.kernel.embedded_gradient(U, by_embedding) + (dk @ self.alpha).T
        return self.scale * value, self.scale * gradient

    def _phase(self, U: Array) -> Array:
        X = np.column_stack([U, np.full(len(U), float(self.time))])
        return np.asarray(self.kernel.embed(X) @ self.omega.T + self.b)


@dataclass(frozen=True, eq=False)
class GridPath:
    """f = E[f | the data, and its values at the points of a grid], those drawn from the posterior.

    It needs no spectral density. Between points that lie farther apart than the length scales it is too tame.
    """

    from_samples: CrossCovariance
    from_grid: CrossCovariance
    level: float
    """mu_0 of the scaled xi."""
    scale: float
    alpha: Array
    """Weights of the samples `(S,)`."""
    beta: Array
    """Weights of the grid points `(G,)`."""

    @classmethod
    def of(cls, now: "TimeSlice", points: int, rng: np.random.Generator) -> "GridPath":
        """Draw from the posterior at one time, at about so many points."""
        from scipy.linalg import cholesky, solve_triangular

        p, ticks = now.posterior, np.linspace(0.0, 1.0, max(2, round(points**0.5)))
        Z = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
        from_grid = p.kernel.cross_covariance(p.theta, Z)
        variance, told = np.exp(2.0 * p.theta[3]), now.k_s(Z) @ now.root.T
        covariance = variance * from_grid(Z) - told @ told.T
        covariance[np.diag_indices(len(Z))] += JITTER * variance
        # Z is drawn as its mean plus L z, and C^-1 L z = L^-T z weighs what that adds elsewhere.
        upper = cholesky(covariance)
        add = solve_triangular(upper, rng.normal(size=len(Z)))
        alpha = now.alpha - now.root.T @ (told.T @ add)
        return cls(now.k_s, from_grid, p.level, p.scale, alpha, variance * add)

    def value(self, U: Array) -> Array:
        """F `(n,)` at U `(n, 2)`, in units of xi."""
        told = self.from_samples(U) @ self.alpha + self.from_grid(U) @ self.beta
        return np.asarray(self.scale * (self.level + told))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """F `(n,)` and its gradient `(n, 2)` at U `(n, 2)`."""
        k, dk = self.from_samples.gradient(U)
        g, dg = self.from_grid.gradient(U)
        value = self.level + k @ self.alpha + g @ self.beta
        return self.scale * value, self.scale * (dk @ self.alpha + dg @ self.beta).T
