"""What a minimiser is given: a function of u = (kappa, d) in model coordinates, with its gradient."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from deformpush.gp.profiles import Array
from deformpush.model.base import Surface


class Objective(Protocol):
    """A function of u to minimise, in batches."""

    def value(self, U: Array) -> Array:
        """Values `(n,)` at U `(n, 2)`."""

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)` at U `(n, 2)`."""


class Partials(NamedTuple):
    """a(mu, sigma) and its derivatives, each `(n,)`."""

    a: Array
    by_mu: Array
    by_sigma: Array


class MuSigma(Protocol):
    """A function of mu and sigma `(n,)`."""

    def __call__(self, mu: Array, sigma: Array) -> Partials:
        """Value and derivatives."""


@dataclass(frozen=True, eq=False)
class OverSurface:
    """The objective u -> a(mu(u), sigma(u))."""

    surface: Surface
    a: MuSigma

    def value(self, U: Array) -> Array:
        """Values `(n,)` at U `(n, 2)`."""
        return self.a(*self.surface.predict(U)).a

    def gradient(self, U: Array) -> tuple[Array, Array]:
        """Values `(n,)` and gradients `(n, 2)` at U `(n, 2)`, by the chain rule."""
        mu, sigma, dmu, dsigma = self.surface.gradient(U)
        a, by_mu, by_sigma = self.a(mu, sigma)
        return a, by_mu[:, None] * dmu + by_sigma[:, None] * dsigma
