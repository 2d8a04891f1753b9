"""The spatial kernel between one set of samples and any pushes: evaluated thousands of times a decision."""

from typing import TYPE_CHECKING, Protocol

import numpy as np

from deformpush.gp.correlation import slope
from deformpush.gp.profiles import Array, ArrayOrFloat

if TYPE_CHECKING:
    from deformpush.gp.kernel import Kernel


class CrossCovariance(Protocol):
    """k_s(u, v_i) as a function of u, for samples V `(S, 2)`."""

    def __call__(self, U: Array) -> Array:
        """k_s `(n, S)` at U `(n, 2)`."""

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """k_s `(n, S)` and its gradient with respect to U `(2, n, S)`."""


class ProfileCrossCovariance:
    """With derivatives by hand, and all that does not change from call to call worked out before."""

    def __init__(self, kernel: "Kernel", theta: Array, V: Array) -> None:
        """For samples V `(S, 2)`."""
        self._kernel, self._theta = kernel, theta
        self._rates = kernel.rates(theta)[:2]
        self._minus_rates = -self._rates[:, None, None]
        self._periodic = kernel.kappa == "periodic"
        self._V = (self._rates * V).T[:, None, :].copy()
        angle = np.pi * V[:, 0]
        self._sin, self._cos = np.sin(angle), np.cos(angle)

    def __call__(self, U: Array) -> Array:
        """k_s `(n, S)` at U `(n, 2)`."""
        a, _ = self._scaled(U)
        return self._kernel.values(self._theta, np.abs(a, out=a))

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """k_s `(n, S)` and its gradient with respect to U `(2, n, S)`."""
        a, bend = self._scaled(U)
        k, slopes = self._kernel.spatial(np.abs(a))
        slopes *= a
        slopes *= self._minus_rates
        if self._periodic:
            slopes[0] *= bend
        return k, slopes

    def _scaled(self, U: Array) -> tuple[Array, ArrayOrFloat]:
        """Signed scaled distances `(2, n, S)`, and d delta_kappa / d kappa (1 unless periodic)."""
        a = (self._rates * U).T[:, :, None] - self._V
        if not self._periodic:
            return a, 1.0
        # sin and cos of differences by the addition theorems: no trigonometry on n S numbers.
        angle = np.pi * U[:, :1]
        sin, cos = np.sin(angle), np.cos(angle)
        a[0] = (self._rates[0] / np.pi) * (sin * self._cos - cos * self._sin)
        return a, cos * self._cos + sin * self._sin


class FormulaCrossCovariance:
    """The same from the kernel's values alone."""

    def __init__(self, kernel: "Kernel", theta: Array, V: Array) -> None:
        """For samples V `(S, 2)`."""
        self._kernel, self._theta = kernel, theta
        self._rates = kernel.rates(theta)[:2, None, None]
        self._V = V.T[:, None, :]

    def __call__(self, U: Array) -> Array:
        """k_s `(n, S)` at U `(n, 2)`."""
        apart = self._kernel.apart(U.T[:, :, None] - self._V)
        return self._kernel.values(self._theta, apart * self._rates)

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """k_s `(n, S)` and its gradient with respect to U `(2, n, S)`."""
        rho = np.exp(self._theta[:2])
        return self(U), np.stack([slope(self, U, along) for along in np.diag(rho)]) / rho[:, None, None]
