"""The kernels to choose from: the paper's, its alternatives, and one of any formula."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from deformpush.gp.correlation import Correlation
from deformpush.gp.cross_covariance import CrossCovariance, FormulaCrossCovariance
from deformpush.gp.kernel import Kernel
from deformpush.gp.profiles import MATERN32, MATERN52, RBF, Array, Profile

__all__ = ["FormulaKernel", "Kernel", "Matern32", "Matern52", "Matern52Sum", "SquaredExponential"]


@dataclass(frozen=True)
class Matern52(Kernel):
    """k_s = (1+a+a^2/3) e^-a (1+b+b^2/3) e^-b, a = sqrt(5)|dkappa|/rho_kappa, b = sqrt(5)|dd|/rho_d.

    Eqs. (7)-(8), read as docs/optimizer.md explains.
    """

    profile: ClassVar[Profile] = MATERN52


@dataclass(frozen=True)
class Matern32(Kernel):
    """k_s = (1+a) e^-a (1+b) e^-b, a = sqrt(3)|dkappa|/rho_kappa, b = sqrt(3)|dd|/rho_d: rougher."""

    profile: ClassVar[Profile] = MATERN32


@dataclass(frozen=True)
class SquaredExponential(Kernel):
    """k_s = exp(-dkappa^2 / (2 rho_kappa^2) - dd^2 / (2 rho_d^2)): infinitely smooth."""

    profile: ClassVar[Profile] = RBF


@dataclass(frozen=True)
class Matern52Sum(Kernel):
    """k_s = (1+a+a^2/3) e^-a + (1+b+b^2/3) e^-b: the sum that eq. (8) prints, with the misprints mended."""

    profile: ClassVar[Profile] = MATERN52

    def prior_variance(self, theta: Array) -> float:
        """k(x, x): both summands contribute sigma_f^2."""
        return 2.0 * super().prior_variance(theta)

    def values(self, theta: Array, a: Array) -> Array:
        """k_s at scaled distances a `(2, ...)`: the sum g(a_kappa) + g(a_d)."""
        p, e = self.profile.parts(a)
        g: Array = p * np.exp(-e)
        return np.asarray(g[0] + g[1])

    def spatial(self, a: Array) -> tuple[Array, Array]:
        """k_s at scaled distances a `(2, ...)`, and weights w `(2, ...)` of its derivatives."""
        p, e, q = self.profile.full(a)
        g: Array = p * np.exp(-e)
        return g[0] + g[1], g * q

    def frequencies(self, theta: Array, n: int, rng: np.random.Generator) -> Array:
        """N draws `(n, E)`: every other one varies along kappa only, the rest along d only."""
        omega = super().frequencies(theta, n, rng)
        omega[::2, -2] = 0.0
        omega[1::2, :-2] = 0.0
        return omega


@dataclass(frozen=True)
class FormulaKernel(Kernel):
    """k_s by the formula of a `Correlation`: the product over kappa and d, unless `space.plane` differs.

    Around a closed contour, distances along kappa are straight ones on a circle: there the formula must be
    positive definite in the plane too.
    """

    space: Correlation = field(kw_only=True)
    """Of distances in units of rho_kappa and rho_d."""

    def __post_init__(self) -> None:
        """Check the formulas.

        Raises:
            ValueError: one is not 1 at distance 0.
        """
        super().__post_init__()
        self.space.check("space", 2)

    @property
    def formulas(self) -> dict[str, Correlation]:
        """Those of its factors that are given by a formula alone, by field."""
        return {"space": self.space} | super().formulas

    def values(self, theta: Array, a: Array) -> Array:
        """k_s at scaled distances a `(2, ...)`."""
        return self.formula("space", theta).plane(a)

    def cross_covariance(self, theta: Array, V: Array) -> CrossCovariance:
        """k_s between samples V `(S, 2)` and any pushes."""
        return FormulaCrossCovariance(self, theta, V)

    @property
    def space_rate(self) -> float:
        """1: the formula takes distances over length scales as they are."""
        return 1.0
