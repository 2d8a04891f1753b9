"""A Gaussian process beside a linear trend whose coefficients are integrated out.

y = h(x)^T beta + f(x) + noise with beta ~ N(0, diag(spread^2)): what is not known of beta widens every
prediction, most of all far from where data tell it (Rasmussen & Williams 2006, eqs. 2.40-2.42).
"""

import numpy as np

from deformpush.gp.profiles import Array
from deformpush.gp.regression import Posterior


class TrendPosterior:
    """y at one time, over u = (kappa, d) and the basis values h there."""

    def __init__(self, posterior: Posterior, t: float, H: Array, y: Array, spread: Array) -> None:
        """Learn beta from the samples of a process.

        Args:
            posterior: of which kernel, hyper-parameters and samples X `(S, 3)` are taken; its own level is
                not, a constant belongs into the basis.
            t: time of the predictions.
            H: basis at the samples `(S, m)`.
            y: values at the samples `(S,)`.
            spread: prior standard deviation of each coefficient `(m,)`, in units of y per unit of h.
        """
        self._slice = posterior.at(t)
        self._scale = posterior.scale
        root = posterior.root
        # Whitened by L^-1 the samples have unit covariance, and all becomes least squares.
        W, w = root @ (H / self._scale), root @ (y / self._scale)
        information = W.T @ W + np.diag(np.asarray(spread, float) ** -2)
        self.beta = np.linalg.solve(information, W.T @ w)
        """Posterior mean of the coefficients `(m,)`."""
        self.doubt = np.linalg.inv(information)
        """Their posterior covariance `(m, m)`."""
        amplitude = self._slice.amplitude
        self._alpha = amplitude * (root.T @ (w - W @ self.beta))
        self._told = amplitude[:, None] * (root.T @ W)

    def predict(self, U: Array, H: Array) -> tuple[Array, Array]:
        """Mean and standard deviation of y less noise, each `(n,)`, at U `(n, 2)` with basis H `(n, m)`."""
        _, sigma = self._slice.predict(U)
        k = self._slice.k_s(U)
        rest = H - self._scale * (k @ self._told)
        mu = self._scale * (k @ self._alpha) + H @ self.beta
        return mu, np.sqrt(sigma**2 + np.einsum("ni,ij,nj->n", rest, self.doubt, rest))

    def gradient(self, U: Array, H: Array) -> tuple[Array, Array, Array, Array]:
        """The same and their gradients by U `(n, 2)`, for a basis that does not change with U."""
        _, sigma, _, dsigma = self._slice.gradient(U)
        k, dk = self._slice.k_s.gradient(U)
        rest = H - self._scale * (k @ self._told)
        mu = self._scale * (k @ self._alpha) + H @ self.beta
        total = np.sqrt(sigma**2 + np.einsum("ni,ij,nj->n", rest, self.doubt, rest))
        dmu = self._scale * (dk @ self._alpha).T
        drest = -self._scale * (dk @ self._told)
        pull = np.einsum("ni,ij,anj->na", rest, self.doubt, drest)
        return mu, total, dmu, (sigma[:, None] * dsigma + pull) / total[:, None]
