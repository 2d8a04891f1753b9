"""The floor: any push, any time."""

from dataclasses import dataclass
from typing import ClassVar

from deformpush.optimizer.base import AskTellOptimizer, Components
from deformpush.state import Proposal, State


@dataclass(eq=False)
class RandomPush(AskTellOptimizer):
    """u ~ U(outer bounds), independent of everything."""

    parts: Components
    S0: ClassVar[int] = 0
    """No initial samples: all pushes are of one kind."""

    def __post_init__(self) -> None:
        """Start without a design."""
        super().__init__(self.parts, 0)

    def _choose(self, state: State | None) -> Proposal:
        u = self._in_outer(self._rng().random((1, 2)))[0]
        return Proposal(u, "explore", self.history.outer)
