"""One-dimensional correlation functions g(a) of the scaled distance a = rate |x - x'| / rho.

Each is written g(a) = p(a) exp(-e(a)), so that a product of several needs one exponential, and comes with
q(a) = -g'(a) / (a g(a)), from which both derivatives follow without a singularity at a = 0:
dg/dlog(rho) = g q a^2 and dg/dx = -g q a rate / rho, a signed. Formulas: Rasmussen & Williams 2006, section
4.2.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ArrayOrFloat = Array | float


class Profile(NamedTuple):
    """A correlation function of one coordinate."""

    rate: float
    parts: Callable[[Array], tuple[ArrayOrFloat, Array]]
    """a -> (p, e)."""
    full: Callable[[Array], tuple[ArrayOrFloat, Array, ArrayOrFloat]]
    """a -> (p, e, q)."""
    freedom: float
    """The spectral density is Student's t with this many degrees of freedom (infinite: Gaussian)."""

    def frequencies(self, shape: tuple[int, int], rng: np.random.Generator) -> Array:
        """Draws `(n, D)` from the spectral density over D coordinates, for length scale 1."""
        normal = rng.normal(size=shape)
        if np.isinf(self.freedom):
            return normal
        return np.asarray(normal * np.sqrt(self.freedom / rng.chisquare(self.freedom, (shape[0], 1))))


def _matern52(a: Array) -> tuple[Array, Array]:
    p = a * (1.0 / 3.0)
    p += 1.0
    p *= a
    p += 1.0
    return p, a


def _matern52_full(a: Array) -> tuple[Array, Array, Array]:
    p, _ = _matern52(a)
    q = a * (1.0 / 3.0)
    q += 1.0 / 3.0
    q /= p
    return p, a, q


def _matern32(a: Array) -> tuple[Array, Array]:
    return 1.0 + a, a


def _matern32_full(a: Array) -> tuple[Array, Array, Array]:
    p = 1.0 + a
    return p, a, 1.0 / p


def _rbf(a: Array) -> tuple[float, Array]:
    return 1.0, 0.5 * a * a


def _rbf_full(a: Array) -> tuple[float, Array, float]:
    return *_rbf(a), 1.0


def _ou(a: Array) -> tuple[float, Array]:
    return 1.0, a


def _ou_full(a: Array) -> tuple[float, Array, Array]:
    # The cusp at a = 0 has no slope; q a^2 = a holds all the same, and the length scale asks for no more.
    return 1.0, a, 1.0 / np.maximum(a, 1e-300)


MATERN52 = Profile(np.sqrt(5.0), _matern52, _matern52_full, 5.0)
"""g = (1 + a + a^2/3) exp(-a), rate sqrt(5)."""
MATERN32 = Profile(np.sqrt(3.0), _matern32, _matern32_full, 3.0)
"""g = (1 + a) exp(-a), rate sqrt(3)."""
RBF = Profile(1.0, _rbf, _rbf_full, np.inf)
"""g = exp(-a^2 / 2), rate 1."""
OU = Profile(1.0, _ou, _ou_full, 1.0)
"""g = exp(-a), rate 1: Ornstein and Uhlenbeck's; differentiable nowhere, therefore for time only."""
