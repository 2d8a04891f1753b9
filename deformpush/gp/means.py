"""Prior mean mu_0 of xi. Neither choice centres the data behind the user's back."""

from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from annotated_types import Interval


class Mean(Protocol):
    """A constant prior mean, chosen with the covariance of the data in hand."""

    def level(self, ones: float, y: float) -> float:
        """mu_0 from 1^T K^-1 1 and 1^T K^-1 y."""

    def log_prior(self, level: float) -> float:
        """Log density of mu_0, up to a constant."""


@dataclass(frozen=True)
class Zero:
    """mu_0 = 0 (paper): an untried push changes nothing."""

    def level(self, ones: float, y: float) -> float:
        """Zero, whatever the data."""
        return 0.0

    def log_prior(self, level: float) -> float:
        """Nothing to weigh."""
        return 0.0


@dataclass(frozen=True)
class Constant:
    """mu_0 = (1^T K^-1 y) / (1^T K^-1 1 + 1 / spread^2): MAP of a constant with prior N(0, spread^2).

    Rasmussen & Williams 2006, eq. (2.43) with one constant basis function.
    """

    spread: Annotated[float, Interval(ge=1e-3, le=1e3)] = 1.0
    """Prior standard deviation of the constant, in units of the root mean square of xi."""

    def level(self, ones: float, y: float) -> float:
        """Generalised least squares, pulled towards zero by the prior."""
        return y / (ones + self.spread**-2)

    def log_prior(self, level: float) -> float:
        """-mu_0^2 / (2 spread^2)."""
        return float(-0.5 * np.square(level / self.spread))
