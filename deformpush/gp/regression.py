"""Gaussian process regression, eqs. (9)-(11), by Cholesky factors in float64.

Printed (10) and (11) have no noise; K here is K + (noise^2 + jitter) I, or a push repeated would make it
singular.
"""

from dataclasses import dataclass

import numpy as np

from deformpush.gp.cholesky import Cholesky, below
from deformpush.gp.kernel import Kernel
from deformpush.gp.means import Mean
from deformpush.gp.profiles import Array
from deformpush.gp.sample_path import GridPath, SamplePath, SpectralPath


def residual(factor: Cholesky, mean: Mean, y: Array) -> tuple[float, Array, Array]:
    """mu_0, y - mu_0 `(S,)` and alpha = K^-1 (y - mu_0) `(S,)`."""
    solved = factor.solve(np.stack([np.ones_like(y), y], axis=1))
    level = mean.level(float(solved[:, 0].sum()), float(solved[:, 1].sum()))
    return level, y - level, solved[:, 1] - level * solved[:, 0]


def log_likelihood(
    kernel: Kernel, theta: Array, mean: Mean, distances: Array, y: Array, work: Array | None = None
) -> tuple[float, Array]:
    """Log marginal likelihood and its gradient with respect to theta.

    log p = -1/2 (y - mu_0)^T alpha - 1/2 log|K| - S/2 log(2 pi),
    dlog p/dtheta = 1/2 tr((alpha alpha^T - K^-1) dK/dtheta) (Rasmussen & Williams 2006, eqs. 5.8 and 5.9).
    A learnt mu_0 sits at its own maximum, so it adds nothing to the gradient of the sum with its log prior,
    which is what is returned. `work` `(len(theta) - 1, S(S-1)/2)` is room that calls may share.
    """
    S = len(y)
    work = np.empty((len(theta) - 1, distances.shape[1])) if work is None else work
    k, slopes = kernel.gram_gradient(theta, distances, work)
    factor = Cholesky(kernel, theta, k, S)
    level, rest, alpha = residual(factor, mean, y)
    value = -0.5 * float(rest @ alpha) - 0.5 * factor.log_determinant() - 0.5 * S * np.log(2.0 * np.pi)

    inverse = factor.inverse()
    weights = np.outer(alpha, alpha)
    weights -= inverse
    weights = weights.reshape(-1).take(below(S))
    diagonal = float(alpha @ alpha - np.trace(inverse))
    gradient = np.empty(len(theta))
    gradient[:3] = slopes[:3] @ weights
    gradient[5:] = slopes[3:] @ weights
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
        factor = Cholesky(kernel, theta, kernel.gram(theta, kernel.distances(X)), len(X))
        level, _, alpha = residual(factor, mean, xi / scale)
        return cls(kernel, theta, X, level, alpha, factor.inverse_root(), scale, factor.jitter)

    def at(self, t: float) -> "TimeSlice":
        """The posterior over (kappa, d) at time t: t is pinned, never optimised."""
        amplitude = np.exp(2.0 * self.theta[3]) * self.kernel.temporal(self.theta, t - self.X[:, 2])
        return TimeSlice(self, t, amplitude)


class TimeSlice:
    """mu and sigma over u = (kappa, d) at one time."""

    def __init__(self, posterior: Posterior, t: float, amplitude: Array) -> None:
        """With the amplitude sigma_f^2 k_t(t, t_i) `(S,)` of each sample at time t."""
        self.posterior, self.t, self.amplitude = posterior, t, amplitude
        self.alpha, self.root = amplitude * posterior.alpha, posterior.root * amplitude
        self._variance = posterior.kernel.prior_variance(posterior.theta)
        self.k_s = posterior.kernel.cross_covariance(posterior.theta, posterior.X[:, :2])

    def predict(self, U: Array) -> tuple[Array, Array]:
        """mu_0 + k^T alpha (10) and sqrt(k(x, x) - k^T K^-1 k) (11) at U `(n, 2)`, each `(n,)`."""
        p = self.posterior
        mu, sigma = np.empty(len(U)), np.empty(len(U))
        # In blocks whose work arrays stay in the cache.
        block = max(16, 12_800 // len(p.X))
        for i in range(0, len(U), block):
            part = slice(i, i + block)
            k = self.k_s(U[part])
            mu[part] = p.level + k @ self.alpha
            sigma[part] = self._sigma(k @ self.root.T)
        return p.scale * mu, p.scale * sigma

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """mu, sigma `(n,)` and their gradients with respect to U `(n, 2)`."""
        p = self.posterior
        k, dk = self.k_s.gradient(U)
        v = k @ self.root.T
        sigma = self._sigma(v)
        dmu = dk @ self.alpha
        dk *= v @ self.root
        dsigma = dk.sum(axis=2) / -sigma
        return (
            p.scale * (p.level + k @ self.alpha),
            p.scale * sigma,
            p.scale * dmu.T,
            p.scale * dsigma.T,
        )

    def draw(self, features: int, rng: np.random.Generator) -> SamplePath:
        """Draw one function, from so many random Fourier features or, for a formula, grid points."""
        if self.posterior.kernel.formulas:
            return GridPath.of(self, features, rng)
        return SpectralPath.of(self, features, rng)

    def _sigma(self, v: Array) -> Array:
        # Rounding may leave a tiny negative variance at a sample; at 0 sigma would have no gradient.
        variance = self._variance - np.einsum("ns,ns->n", v, v)
        return np.asarray(np.sqrt(np.maximum(variance, 1e-14 * self._variance)))
