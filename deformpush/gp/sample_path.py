"""One function drawn from the posterior, as a formula that can be evaluated and differentiated anywhere."""

from dataclasses import dataclass

import numpy as np

from deformpush.gp.cross_covariance import CrossCovariance
from deformpush.gp.kernels import Kernel
from deformpush.gp.profiles import Array


@dataclass(frozen=True, eq=False)
class SamplePath:
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
