"""A Gaussian process that data were told to, as plain numbers."""

from dataclasses import dataclass

from deformpush.gp.kernel import Kernel
from deformpush.gp.profiles import Array


@dataclass(frozen=True, eq=False)
class Conditioned:
    """Samples, hyper-parameters and weights in units of xi: y = xi / scale is what the kernel sees."""

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
