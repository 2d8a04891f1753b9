"""Gaussian process regression, eqs. (9)-(11), by Cholesky factors in float64.

Printed (10) and (11) have no noise; K here is K + (noise^2 + jitter) I, otherwise a push repeated would make it singular.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Mean

JITTERS = (0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Tried in turn, as multiples of k(x, x), until the factor exists."""


@lru_cache(maxsize=4)
def _below(S: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the entries below the diagonal, in the order of `Kernel.distances`."""
    i, j = np.tril_indices(S, -1)
    return i, j


class Factor:
    """K = L L^T, with what the likelihood and the prediction both need."""

    def __init__(self, kernel: Kernel, theta: np.ndarray, pairs: np.ndarray, S: int) -> None:
        """Factor the covariance of S samples from the off-diagonal entries `pairs` `(S(S-1)/2,)`.

        Raises:
            np.linalg.LinAlgError: no jitter up to 1e-3 k(x, x) makes K positive definite (K is not finite).
        """
        from scipy.linalg.lapack import dpotrf

        variance = kernel.prior_variance(theta)
        K = np.empty((S, S), order="F")
        K[_below(S)] = pairs
        for jitter in JITTERS:
            np.fill_diagonal(K, variance * (1.0 + jitter) + np.exp(2.0 * theta[4]))
            self.L, failed = dpotrf(K, lower=1, clean=1)
            if not failed and np.isfinite(self.L[-1, -1]):
                self.jitter = jitter * variance
                return
        raise np.linalg.LinAlgError(f"covariance of {S} samples is not positive definite")

    def solve(self, b: np.ndarray) -> np.ndarray:
        """K^-1 b."""
        from scipy.linalg.lapack import dpotrs

        return np.asarray(dpotrs(self.L, b, lower=1)[0])

    def inverse(self) -> np.ndarray:
        """Lower triangle of K^-1."""
        from scipy.linalg.lapack import dpotri

        return np.asarray(dpotri(self.L, lower=1)[0])

    def inverse_root(self) -> np.ndarray:
        """L^-1; its error grows with the root of K's condition number, that of K^-1 with the number itself."""
        from scipy.linalg.lapack import dtrtri

        return np.ascontiguousarray(dtrtri(self.L, lower=1)[0])

    def log_determinant(self) -> float:
        """Log |K|."""
        return 2.0 * float(np.log(np.diagonal(self.L)).sum())


def residual(factor: Factor, mean: Mean, y: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """mu_0, y - mu_0 `(S,)` and alpha = K^-1 (y - mu_0) `(S,)`."""
    solved = factor.solve(np.stack([np.ones_like(y), y], axis=1))
    level = mean.level(float(solved[:, 0].sum()), float(solved[:, 1].sum()))
    return level, y - level, solved[:, 1] - level * solved[:, 0]


def log_likelihood(
    kernel: Kernel, theta: np.ndarray, mean: Mean, distances: np.ndarray, y: np.ndarray
) -> tuple[float, np.ndarray]:
    """Log marginal likelihood and its gradient with respect to theta `(5,)`.

    log p = -1/2 (y - mu_0)^T alpha - 1/2 log|K| - S/2 log(2 pi), dlog p/dtheta = 1/2 tr((alpha alpha^T - K^-1) dK/dtheta)
    (Rasmussen & Williams 2006, eqs. 5.8 and 5.9). A learnt mu_0 sits at its own maximum, so it adds nothing to the
    gradient of the sum with its log prior, which is what is returned.
    """
    S = len(y)
    k, slopes = kernel.gram(theta, distances)
    factor = Factor(kernel, theta, k, S)
    level, rest, alpha = residual(factor, mean, y)
    value = -0.5 * float(rest @ alpha) - 0.5 * factor.log_determinant() - 0.5 * S * np.log(2.0 * np.pi)

    inverse = factor.inverse()
    i, j = _below(S)
    weights = alpha[i] * alpha[j] - inverse[i, j]
    diagonal = float(alpha @ alpha - np.trace(inverse))
    gradient = np.empty(5)
    gradient[:3] = slopes @ weights
    # dK/dlog(sigma_f) = 2 K without the noise; the jitter, a multiple of k(x, x), scales with it.
    gradient[3] = 2.0 * float(k @ weights) + diagonal * (kernel.prior_variance(theta) + factor.jitter)
    gradient[4] = diagonal * np.exp(2.0 * theta[4])
    return value + mean.log_prior(level), gradient


@dataclass(frozen=True, eq=False)
class Posterior:
    """f | X, Y of eq. (9) in units of xi: y = xi / scale is what the kernel sees."""

    kernel: Kernel
    theta: np.ndarray
    X: np.ndarray
    """Samples `(S, 3)` in model coordinates (kappa, d, t)."""
    level: float
    """mu_0 of the scaled xi."""
    alpha: np.ndarray
    """K^-1 (y - mu_0) `(S,)`."""
    root: np.ndarray
    """L^-1 `(S, S)`."""
    scale: float
    jitter: float

    @classmethod
    def of(
        cls, kernel: Kernel, theta: np.ndarray, mean: Mean, X: np.ndarray, xi: np.ndarray, scale: float
    ) -> "Posterior":
        """Condition on pushes X `(S, 3)` that changed e_T by xi `(S,)`."""
        k, _ = kernel.gram(theta, kernel.distances(X))
        factor = Factor(kernel, theta, k, len(X))
        level, _, alpha = residual(factor, mean, xi / scale)
        return cls(kernel, theta, X, level, alpha, factor.inverse_root(), scale, factor.jitter)

    def at(self, t: float) -> "Surface":
        """The posterior over (kappa, d) at time t."""
        amplitude = np.exp(2.0 * self.theta[3]) * self.kernel.temporal(self.theta, t - self.X[:, 2])
        return Surface(self, amplitude)


@dataclass(frozen=True, eq=False)
class Surface:
    """mu and sigma over u = (kappa, d) at one time: t is pinned, never optimised."""

    posterior: Posterior
    amplitude: np.ndarray
    """sigma_f^2 k_t(t, t_i) `(S,)`."""

    def predict(self, U: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mu = mu_0 + k^T alpha (10) and sigma = sqrt(k(x, x) - k^T K^-1 k) (11) at U `(n, 2)`, each `(n,)`."""
        p = self.posterior
        k = p.kernel.cross(p.theta, U, p.X[:, :2]) * self.amplitude
        v = k @ p.root.T
        return p.scale * (p.level + k @ p.alpha), p.scale * self._sigma(v)

    def gradient(self, U: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """mu, sigma `(n,)` and their gradients with respect to U `(n, 2)`."""
        p = self.posterior
        k, dk = p.kernel.cross_gradient(p.theta, U, p.X[:, :2])
        k *= self.amplitude
        dk *= self.amplitude
        v = k @ p.root.T
        sigma = self._sigma(v)
        dmu = (dk @ p.alpha).T
        dsigma = -np.einsum("ans,ns->na", dk, v @ p.root) / sigma[:, None]
        return p.scale * (p.level + k @ p.alpha), p.scale * sigma, p.scale * dmu, p.scale * dsigma

    def _sigma(self, v: np.ndarray) -> np.ndarray:
        variance = self.posterior.kernel.prior_variance(self.posterior.theta)
        # Rounding may leave a tiny negative variance at a sample; sigma stays away from 0, where it has no gradient.
        return np.sqrt(np.maximum(variance - np.einsum("ns,ns->n", v, v), 1e-14 * variance))
