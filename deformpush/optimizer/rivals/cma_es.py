"""CMA-ES (Hansen 2016) through the `cmaes` package (Nomura & Shibata 2024) as a rival."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from annotated_types import Interval

from deformpush.extras import library
from deformpush.optimizer.base import AskTellOptimizer, Components
from deformpush.state import Proposal, State


@dataclass(eq=False)
class CMAES(AskTellOptimizer):
    """Evolution strategy over the unit square of the outer bounds, from its centre. It knows no time.

    Every ask replays the history into a fresh strategy with the same seed: exact, repeatable, and cheap at
    this size.
    """

    parts: Components
    sigma: Annotated[float, Interval(gt=0, le=1)] = 0.3
    """First step, as a fraction of the outer width."""
    S0: ClassVar[int] = 0
    """No initial samples: the first generation is its own design."""

    def __post_init__(self) -> None:
        """Start without a design, and fail at once if the library is missing."""
        library("cmaes")
        super().__init__(self.parts, 0)

    def _choose(self, state: State | None) -> Proposal:
        from cmaes import CMA

        lo, hi = self.history.outer.T
        strategy = CMA(
            mean=np.full(2, 0.5), sigma=self.sigma, bounds=np.array([[0.0, 1.0]] * 2), seed=self._seed % 2**32
        )
        unit = (self.history.U - lo) / (hi - lo)
        size = strategy.population_size
        for i in range(0, len(unit) - size + 1, size):
            for _ in range(size):
                strategy.ask()
            strategy.tell([(unit[i + j], float(self.history.xi[i + j])) for j in range(size)])
        for _ in range(len(unit) % size):
            strategy.ask()
        return Proposal(self._in_outer(strategy.ask()[None])[0], "explore", self.history.outer)
