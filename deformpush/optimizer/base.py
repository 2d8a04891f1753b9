"""What all optimizers share: the history, one answer per push, saving and restoring."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np

from deformpush.optimizer.history import History
from deformpush.optimizer.protocol import Parts, Proposal


class Asker(ABC):
    """Answers depend on the seed and on what was told, on nothing else: repeatable and restorable."""

    def __init__(self, parts: Parts, S0: int) -> None:
        """Draw the S0 points of the design and the seed of all later draws."""
        self.history = History(parts.bounds.outer)
        self._bounds = parts.bounds
        self._design = self._in_outer(parts.design.points(S0, parts.rng)) if S0 else np.empty((0, 2))
        self._seed = int(parts.rng.integers(2**63))
        self._proposal: Proposal | None = None

    @property
    def rejected(self) -> int:
        """Tells refused so far."""
        return self.history.rejected

    def ask(self, state: Any | None = None) -> Proposal:
        """Choose the next push: the next point of the design, then what the method says."""
        if self._proposal is None:
            S = len(self.history)
            if len(self._design) > S:
                self._proposal = Proposal(self._design[S].copy(), "initial", self.history.outer)
            else:
                self._proposal = self._choose(state)
        return self._proposal

    def tell(self, u: Any, xi: Any, before: Any | None = None, after: Any | None = None) -> None:
        """Learn that push u, asked for or not, changed e_T by xi.

        Raises:
            ValueError: u or xi is not finite, of the wrong shape, or outside the outer bounds; counted in
            `rejected`.
        """
        self.history.add(u, xi)
        self._proposal = None

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """Nothing: there is no model."""
        return {}

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays and numbers only."""
        return self.history.state() | {"design": self._design.copy(), "seed": self._seed}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there.

        Raises:
            ValueError: it was saved under other outer bounds or another S0.
        """
        design = np.asarray(state["design"], float).reshape(-1, 2)
        if len(design) != len(self._design):
            raise ValueError(f"restore: saved with S0={len(design)}, now S0={len(self._design)}")
        self.history.restore(state)
        self._design, self._seed = design, int(state["seed"])
        self._proposal = None

    @abstractmethod
    def _choose(self, state: Any | None) -> Proposal:
        """The push after the design."""

    def _bounds_now(self, state: Any | None) -> np.ndarray:
        return self._bounds.now(self.history.U, self.history.xi, getattr(state, "e_T_share", None))

    def _rng(self, purpose: int = 0) -> np.random.Generator:
        """The generator of this decision: the same whenever it is asked for."""
        return np.random.default_rng([self._seed, len(self.history), purpose])

    def _in_outer(self, unit: np.ndarray) -> np.ndarray:
        """Points of the unit square `(n, 2)` to (kappa, d in metres)."""
        lo, hi = self._bounds.outer.T
        return np.asarray(lo + unit * (hi - lo))
