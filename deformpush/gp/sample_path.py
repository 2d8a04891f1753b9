"""One function drawn from the posterior, as a formula that can be evaluated and differentiated anywhere."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from deformpush.gp.profiles import Array

if TYPE_CHECKING:
    from deformpush.gp.regression import Surface


@dataclass(frozen=True, eq=False)
class SamplePath:
    """f = mu_0 + f_0 + k^T K^-1 (y - mu_0 - f_0(X) - noise), f_0 a prior draw (Wilson et al. 2020)."""

    surface: "Surface"
    time: float
    omega: Array
    """Frequencies `(F, E)` of the features cos(omega . embedded x + b)."""
    b: Array
    amplitude: float
    alpha: Array
    """sigma_f^2 k_t K^-1 (...) `(S,)`."""

    @classmethod
    def draw(cls, surface: "Surface", time: float, features: int, rng: np.random.Generator) -> "SamplePath":
        """Draw from the posterior over (kappa, d) at `time` with so many random Fourier features."""
        p = surface.posterior
        omega = p.kernel.frequencies(p.theta, features, rng)
        b = rng.uniform(0.0, 2.0 * np.pi, features)
        amplitude = float(np.sqrt(2.0 * p.kernel.prior_variance(p.theta) / features))
        prior = amplitude * np.cos(p.kernel.embed(p.X) @ omega.T + b).sum(axis=1)
        noise = np.exp(p.theta[4]) * rng.normal(size=len(p.X))
        # y = mu_0 + K alpha, and K^-1 = root^T root: the data enter through alpha alone.
        correction = p.root.T @ (p.root @ (prior + noise))
        return cls(surface, time, omega, b, amplitude, surface.amplitude * (p.alpha - correction))

    def value(self, U: Array) -> Array:
        """F `(n,)` at U `(n, 2)`, in units of xi."""
        p = self.surface.posterior
        k = self.surface.k_s(U)
        return np.asarray(
            p.scale * (p.level + self.amplitude * np.cos(self._phase(U)).sum(axis=1) + k @ self.alpha)
        )

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """F `(n,)` and its gradient `(n, 2)` at U `(n, 2)`."""
        p = self.surface.posterior
        phase = self._phase(U)
        k, dk = self.surface.k_s.gradient(U)
        value = p.level + self.amplitude * np.cos(phase).sum(axis=1) + k @ self.alpha
        by_embedding = -self.amplitude * np.sin(phase) @ self.omega
        gradient = p.kernel.embedded_gradient(U, by_embedding) + (dk @ self.alpha).T
        return p.scale * value, p.scale * gradient

    def _phase(self, U: Array) -> Array:
        X = np.column_stack([U, np.full(len(U), float(self.time))])
        return np.asarray(self.surface.posterior.kernel.embed(X) @ self.omega.T + self.b)
