"""The spatial kernel between one set of samples and any pushes: evaluated thousands of times a decision."""

import numpy as np

from deformpush.gp.kernels import Kernel
from deformpush.gp.profiles import Array, Factor


class CrossCovariance:
    """k_s(u, v_i) as a function of u, with all that does not change from call to call worked out before."""

    def __init__(self, kernel: Kernel, theta: Array, V: Array) -> None:
        """For samples V `(S, 2)`."""
        self._kernel = kernel
        self._rates = kernel.rates(theta)[:2]
        self._minus_rates = -self._rates[:, None, None]
        self._periodic = kernel.kappa == "periodic"
        self._V = (self._rates * V).T[:, None, :].copy()
        angle = np.pi * V[:, 0]
        self._sin, self._cos = np.sin(angle), np.cos(angle)

    def __call__(self, U: Array) -> Array:
        """k_s `(n, S)` at U `(n, 2)`."""
        a, _ = self._scaled(U)
        return self._kernel.values(np.abs(a, out=a))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """k_s `(n, S)` and its gradient with respect to U `(2, n, S)`."""
        a, bend = self._scaled(U)
        k, slopes = self._kernel.spatial(np.abs(a))
        slopes *= a
        slopes *= self._minus_rates
        if self._periodic:
            slopes[0] *= bend
        return k, slopes

    def _scaled(self, U: Array) -> tuple[Array, Factor]:
        """Signed scaled distances `(2, n, S)`, and d delta_kappa / d kappa (1 unless periodic)."""
        a = (self._rates * U).T[:, :, None] - self._V
        if not self._periodic:
            return a, 1.0
        # sin and cos of differences by the addition theorems: no trigonometry on n S numbers.
        angle = np.pi * U[:, :1]
        sin, cos = np.sin(angle), np.cos(angle)
        a[0] = (self._rates[0] / np.pi) * (sin * self._cos - cos * self._sin)
        return a, cos * self._cos + sin * self._sin
