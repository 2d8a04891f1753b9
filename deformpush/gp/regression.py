"""Gaussian process regression, eqs. (9)-(11), by Cholesky factors in float64.

Printed (10) and (11) have no noise; K here is K + (noise^2 + jitter) I, or a push repeated would make it
singular.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from deformpush.gp.cross_covariance import CrossCovariance
from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Mean
from deformpush.gp.profiles import Array
from deformpush.gp.sample_path import SamplePath

JITTERS = (0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Tried in turn, as multiples of k(x, x), until the factor exists."""


@lru_cache(maxsize=4)
def _below(S: int) -> np.ndarray:
    """Flat indices below the diagonal of an `(S, S)` array, in the order of `Kernel.distances`."""
    i, j = np.tril_indices(S, -1)
    return np.asarray(i * S + j)


class Factor:
    """K = L L^T, with what the likelihood and the prediction both need.

    LAPACK stores by columns, numpy by rows: the lower triangle here is its upper one, and nothing is copied.
    """

    def __init__(self, kernel: Kernel, theta: Array, pairs: Array, S: int) -> None:
        """Factor the covariance of S samples from the off-diagonal entries `pairs` `(S(S-1)/2,)`.

        Raises:
            np.linalg.LinAlgError: no jitter up to 1e-3 k(x, x) makes K positive definite (K is not finite).
        """
        from scipy.linalg.lapack import dpotrf

        variance = kernel.prior_variance(theta)
        K = np.zeros((S, S))
        K.reshape(-1)[_below(S)] = pairs
        for jitter in JITTERS:
            np.fill_diagonal(K, variance * (1.0 + jitter) + np.exp(2.0 * theta[4]))
            self.upper, failed = dpotrf(K.T, lower=0, clean=0)
            if not failed and np.isfinite(self.upper[-1, -1]):
                self.jitter = jitter * variance
                return
        raise np.linalg.LinAlgError(f"covariance of {S} samples is not positive definite")

    def solve(self, b: Array) -> Array:
        """K^-1 b."""
        from scipy.linalg.lapack import dpotrs

        return np.asarray(dpotrs(self.upper, b, lower=0)[0])

    def inverse(self) -> Array:
        """K^-1 below and on the diagonal; what stands above it is of no meaning."""
        from scipy.linalg.lapack import dpotri

        return np.asarray(dpotri(self.upper, lower=0)[0]).T

    def inverse_root(self) -> Array:
        """L^-1; its error grows with the root of K's condition number, that of K^-1 with all of it."""
        from scipy.linalg.lapack import dtrtri

        return np.asarray(dtrtri(self.upper, lower=0)[0]).T

    def log_determinant(self) -> float:
        """Log |K|."""
        return 2.0 * float(np.log(np.diagonal(self.upper)).sum())


def residual(factor: Factor, mean: Mean, y: Array) -> tuple[float, Array, Array]:
    """mu_0, y - mu_0 `(S,)` and alpha = K^-1 (y - mu_0) `(S,)`."""
    solved = factor.solve(np.stack([np.ones_like(y), y], axis=1))
    level = mean.level(float(solved[:, 0].sum()), float(solved[:, 1].sum()))
    return level, y - level, solved[:, 1] - level * solved[:, 0]


def log_likelihood(
    kernel: Kernel, theta: Array, mean: Mean, distances: Array, y: Array, work: Array | None = None
) -> tuple[float, Array]:
    """Log marginal likelihood and its gradient with respect to theta `(5,)`.

    log p = -1/2 (y - mu_0)^T alpha - 1/2 log|K| - S/2 log(2 pi),
    dlog p/dtheta = 1/2 tr((alpha alpha^T - K^-1) dK/dtheta) (Rasmussen & Williams 2006, eqs. 5.8 and 5.9).
    A learnt mu_0 sits at its own maximum, so it adds nothing to the gradient of the sum with its log prior,
    which is what is returned. `work` `(4, S(S-1)/2)` is room that calls may share.
    """
    S = len(y)
    work = np.empty((4, distances.shape[1])) if work is None else work
    k, slopes = kernel.gram_gradient(theta, distances, work)
    factor = Factor(kernel, theta, k, S)
    level, rest, alpha = residual(factor, mean, y)
    value = -0.5 * float(rest @ alpha) - 0.5 * factor.log_determinant() - 0.5 * S * np.log(2.0 * np.pi)

    inverse = factor.inverse()
    weights = np.outer(alpha, alpha)
    weights -= inverse
    weights = weights.reshape(-1).take(_below(S))
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
    theta: Array
    X: Array
    """Samples `(S, 3)` in model coordinates (kappa, d, t)."""
    level: float
    """mu_0 of the scaled xi."""
    alpha: Array
    """K^-1 (y - mu_0) `(S,)`."""
    root: Array
    """L^-1 `(S, S)`."""
    scale: float
    jitter: float

    @classmethod
    def of(cls, kernel: Kernel, theta: Array, mean: Mean, X: Array, xi: Array, scale: float) -> "Posterior":
        """Condition on pushes X `(S, 3)` that changed e_T by xi `(S,)`."""
        factor = Factor(kernel, theta, kernel.gram(theta, kernel.distances(X)), len(X))
        level, _, alpha = residual(factor, mean, xi / scale)
        return cls(kernel, theta, X, level, alpha, factor.inverse_root(), scale, factor.jitter)

    def at(self, t: float) -> "Surface":
        """The posterior over (kappa, d) at time t: t is pinned, never optimised."""
        amplitude = np.exp(2.0 * self.theta[3]) * self.kernel.temporal(self.theta, t - self.X[:, 2])
        return Surface(self, amplitude)


class Surface:
    """mu and sigma over u = (kappa, d) at one time."""

    def __init__(self, posterior: Posterior, amplitude: Array) -> None:
        """With the amplitude sigma_f^2 k_t(t, t_i) `(S,)` of each sample at that time."""
        self.posterior = posterior
        self.amplitude = amplitude
        self._alpha, self._root = amplitude * posterior.alpha, posterior.root * amplitude
        self._variance = posterior.kernel.prior_variance(posterior.theta)
        self.k_s = CrossCovariance(posterior.kernel, posterior.theta, posterior.X[:, :2])

    def predict(self, U: Array) -> tuple[Array, Array]:
        """mu_0 + k^T alpha (10) and sqrt(k(x, x) - k^T K^-1 k) (11) at U `(n, 2)`, each `(n,)`."""
        p = self.posterior
        mu, sigma = np.empty(len(U)), np.empty(len(U))
        # In blocks whose work arrays stay in the cache.
        block = max(16, 12_800 // len(p.X))
        for i in range(0, len(U), block):
            part = slice(i, i + block)
            k = self.k_s(U[part])
            mu[part] = p.level + k @ self._alpha
            sigma[part] = self._sigma(k @ self._root.T)
        return p.scale * mu, p.scale * sigma

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """mu, sigma `(n,)` and their gradients with respect to U `(n, 2)`."""
        p = self.posterior
        k, dk = self.k_s.gradient(U)
        v = k @ self._root.T
        sigma = self._sigma(v)
        dmu = dk @ self._alpha
        dk *= v @ self._root
        dsigma = dk.sum(axis=2) / -sigma
        return (
            p.scale * (p.level + k @ self._alpha),
            p.scale * sigma,
            p.scale * dmu.T,
            p.scale * dsigma.T,
        )

    def draw(self, time: float, features: int, rng: np.random.Generator) -> SamplePath:
        """Draw one function from the posterior at `time`, with so many random Fourier features."""
        p = self.posterior
        omega = p.kernel.frequencies(p.theta, features, rng)
        b = rng.uniform(0.0, 2.0 * np.pi, features)
        amplitude = float(np.sqrt(2.0 * p.kernel.prior_variance(p.theta) / features))
        prior = amplitude * np.cos(p.kernel.embed(p.X) @ omega.T + b).sum(axis=1)
        noise = np.exp(p.theta[4]) * rng.normal(size=len(p.X))
        # y = mu_0 + K alpha, and K^-1 = root^T root: the data enter through alpha alone.
        alpha = self.amplitude * (p.alpha - p.root.T @ (p.root @ (prior + noise)))
        return SamplePath(p.kernel, self.k_s, p.level, p.scale, time, omega, b, amplitude, alpha)

    def _sigma(self, v: Array) -> Array:
        # Rounding may leave a tiny negative variance at a sample; at 0 sigma would have no gradient.
        variance = self._variance - np.einsum("ns,ns->n", v, v)
        return np.asarray(np.sqrt(np.maximum(variance, 1e-14 * self._variance)))
