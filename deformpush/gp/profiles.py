"""One-dimensional correlation functions g(r) of the scaled distance r = |x - x'| / rho.

Each is written g(r) = p(r) exp(-e(r)), so that a product of several needs a single exponential, and comes with
q(r) = -g'(r) / (r g(r)), from which both derivatives follow without a singularity at r = 0:
dg/dx = -g q (x - x') / rho^2 and dg/dlog(rho) = g q r^2. Formulas: Rasmussen & Williams 2006, section 4.2.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Array = np.ndarray


class Profile(NamedTuple):
    """A correlation function of one coordinate."""

    parts: Callable[[Array], tuple[Array | float, Array]]
    """r -> (p, e) of g = p exp(-e)."""
    slope: Callable[[Array], Array | float]
    """r -> q = -g' / (r g)."""
    freedom: float
    """The spectral density is Student's t with this many degrees of freedom (infinite: Gaussian)."""


def _matern52(r: Array) -> tuple[Array, Array]:
    a = np.sqrt(5.0) * r
    return 1.0 + a * (1.0 + a / 3.0), a


def _matern52_slope(r: Array) -> Array:
    a = np.sqrt(5.0) * r
    b = 1.0 + a
    return 5.0 * b / (3.0 * b + a * a)


def _matern32(r: Array) -> tuple[Array, Array]:
    a = np.sqrt(3.0) * r
    return 1.0 + a, a


def _ou_slope(r: Array) -> Array:
    # The cusp at r = 0 has no slope; q r^2 = r still holds, which is all the length scale's gradient asks for.
    return 1.0 / np.maximum(r, 1e-300)


MATERN52 = Profile(_matern52, _matern52_slope, 5.0)
"""g = (1 + a + a^2/3) exp(-a), a = sqrt(5) r."""
MATERN32 = Profile(_matern32, lambda r: 3.0 / (1.0 + np.sqrt(3.0) * r), 3.0)
"""g = (1 + a) exp(-a), a = sqrt(3) r."""
RBF = Profile(lambda r: (1.0, 0.5 * r * r), lambda r: 1.0, np.inf)
"""g = exp(-r^2 / 2)."""
OU = Profile(lambda r: (1.0, r), _ou_slope, 1.0)
"""g = exp(-r), Ornstein and Uhlenbeck's; differentiable nowhere, therefore for time only."""
