"""The limit: tries pushes for real and takes them back. It cheats, no robot can do that."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from annotated_types import Interval

from deformpush.cell.world import Capability
from deformpush.model.coordinates import grid
from deformpush.optimizer.base import AskTellOptimizer, Branches, Components
from deformpush.state import Proposal, State


@dataclass(eq=False)
class Oracle(AskTellOptimizer):
    """The push of a grid over (kappa, d) with the lowest e_T afterwards, then of a finer one around it.

    It learns nothing and needs no model: each push is made in a copy of the world. What it needs is the least
    that one-step choice can need.
    """

    parts: Components
    kappas: Annotated[int, Interval(ge=2, le=1000)] = 24
    """Places along the effective contour."""
    distances: Annotated[int, Interval(ge=2, le=1000)] = 2
    """Distances, the last one d_max."""
    refined: Annotated[int, Interval(ge=0, le=1000)] = 8
    """Pushes tried around the best of the grid."""
    S0: ClassVar[int] = 0
    """No initial samples: it needs none."""

    def __post_init__(self) -> None:
        """Start without a design."""
        super().__init__(self.parts, 0)
        self._branches: Branches | None = None

    @property
    def needs(self) -> frozenset[Capability]:
        """Copies of the world."""
        return frozenset({"branches"})

    def attach(self, branches: Branches) -> None:
        """Take the branches of the world, before the first ask."""
        self._branches = branches

    def _choose(self, state: State | None) -> Proposal:
        if self._branches is None:
            raise ValueError("ask: optimizer=oracle tries pushes for real, call attach(branches) first")
        lo, hi = self.history.outer.T
        steps = self.kappas if self.parts.closed else self.kappas - 1
        shares = np.arange(1, self.distances + 1) / self.distances
        U = self._on_grid(lo + grid(np.arange(self.kappas) / steps, shares) * (hi - lo))
        e_T = np.nan_to_num(self._branches.e_T_after(U), nan=np.inf)
        centre = U[np.argmin(e_T)]
        if self.refined:
            cell = (hi - lo) / (steps, self.distances)
            near = centre + self._rng().uniform(-1.0, 1.0, (self.refined, 2)) * cell
            if self.parts.closed:
                near[:, 0] = lo[0] + (near[:, 0] - lo[0]) % (hi[0] - lo[0])
            near = self._on_grid(np.clip(near, lo, hi))
            after = np.nan_to_num(self._branches.e_T_after(near), nan=np.inf)
            U, e_T = np.vstack([U, near]), np.append(e_T, after)
        best = int(np.argmin(e_T))
        info = {"cheating": 1.0, "trials": float(len(U)), "e_T_after": float(e_T[best])}
        return Proposal(U[best], "exploit", self.history.outer, info=info)
