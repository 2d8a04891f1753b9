"""The Cholesky factor of a covariance, and what follows from it."""

from functools import lru_cache

import numpy as np

from deformpush.gp.kernel import Kernel
from deformpush.gp.profiles import Array

JITTERS = (0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Tried in turn, as multiples of k(x, x), until the factor exists."""


@lru_cache(maxsize=4)
def below(S: int) -> np.ndarray:
    """Flat indices below the diagonal of an `(S, S)` array, in the order of `Kernel.distances`."""
    i, j = np.tril_indices(S, -1)
    return np.asarray(i * S + j)


class Cholesky:
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
        K.reshape(-1)[below(S)] = pairs
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
