"""Initial designs: S0 points in the unit square that Algorithm 1 pushes first."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np


class Design(Protocol):
    """Spreads the initial samples."""

    def points(self, S0: int, rng: np.random.Generator) -> np.ndarray:
        """S0 points `(S0, 2)` in the unit square."""


@dataclass(frozen=True)
class LHS:
    """Latin hypercube (McKay et al. 1979): every row and column of an S0 x S0 grid holds one point.

    Gives the points of `scipy.stats.qmc.LatinHypercube` to the last bit (a test compares them), drawn here
    because importing scipy.stats would cost every run a second.
    """

    def points(self, S0: int, rng: np.random.Generator) -> np.ndarray:
        """S0 points `(S0, 2)`, uniform within their cells."""
        rng = rng.spawn(1)[0]  # as scipy does
        within = rng.uniform(size=(S0, 2))
        cells = np.tile(np.arange(1, S0 + 1), (2, 1))
        for axis in cells:
            rng.shuffle(axis)
        return np.asarray((cells.T - within) / S0)


@dataclass(frozen=True)
class Sobol:
    """Scrambled Sobol points (Owen 1998): evenest when S0 is a power of two, any S0 is allowed."""

    def points(self, S0: int, rng: np.random.Generator) -> np.ndarray:
        """The first S0 points `(S0, 2)` of the sequence."""
        from scipy.stats.qmc import Sobol as Sequence

        return np.asarray(Sequence(2, rng=rng).random_base2(int(np.ceil(np.log2(max(S0, 1)))))[:S0])


@dataclass(frozen=True)
class Random:
    """Independent uniform points."""

    def points(self, S0: int, rng: np.random.Generator) -> np.ndarray:
        """S0 points `(S0, 2)`."""
        return rng.random((S0, 2))
