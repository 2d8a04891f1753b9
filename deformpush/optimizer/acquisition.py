"""Acquisition functions: all are minimised, over u = (kappa, d) at the time of the next push."""

from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from annotated_types import Ge

from deformpush.gp.regression import Surface


class Objective(Protocol):
    """A function of u to minimise, in batches."""

    def value(self, U: np.ndarray) -> np.ndarray:
        """Values `(n,)` at U `(n, 2)`."""

    def gradient(self, U: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values `(n,)` and gradients `(n, 2)` at U `(n, 2)`."""


@dataclass(frozen=True, eq=False)
class Context:
    """What an acquisition may look at."""

    surface: Surface
    tried: np.ndarray
    """Pushes made so far `(S, 2)`, model coordinates."""
    t: int
    """Number of pushes made so far."""
    rng: np.random.Generator


class Acquisition(Protocol):
    """Turns the posterior into a function to minimise."""

    def objective(self, context: Context) -> Objective:
        """Prepare the function for one decision."""


class MuSigma:
    """An objective a(mu, sigma); subclasses give it and its two partial derivatives."""

    def __init__(self, surface: Surface) -> None:
        """Over this posterior surface."""
        self.surface = surface

    def partials(self, mu: np.ndarray, sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """a, da/dmu, da/dsigma at mu, sigma `(n,)`."""
        raise NotImplementedError

    def value(self, U: np.ndarray) -> np.ndarray:
        """Values `(n,)` at U `(n, 2)`."""
        return self.partials(*self.surface.predict(U))[0]

    def gradient(self, U: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values `(n,)` and gradients `(n, 2)` at U `(n, 2)`."""
        mu, sigma, dmu, dsigma = self.surface.gradient(U)
        value, by_mu, by_sigma = self.partials(mu, sigma)
        return value, by_mu[:, None] * dmu + by_sigma[:, None] * dsigma


class LowerConfidence(MuSigma):
    """mu - w sigma."""

    def __init__(self, surface: Surface, w: float) -> None:
        """With confidence weight w."""
        super().__init__(surface)
        self.w = w

    def partials(self, mu: np.ndarray, sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Linear in both."""
        return mu - self.w * sigma, np.ones_like(mu), np.full_like(mu, -self.w)


@dataclass(frozen=True)
class LCB:
    """LCB(x) = mu(x) - w sigma(x), eq. (12) (Cox & John 1992). w = 0 exploits only."""

    w: Annotated[float, Ge(0)] = 2.0

    def objective(self, context: Context) -> Objective:
        """The bound over the surface of now."""
        return LowerConfidence(context.surface, self.w)
