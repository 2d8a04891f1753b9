"""What a person would do: push towards the goal, off-centre when the object must turn."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from annotated_types import Interval

from deformpush.mechanics.geometry import gyration
from deformpush.mechanics.rounding import lowest
from deformpush.optimizer.base import AskTellOptimizer, Components
from deformpush.state import Proposal, State


@dataclass(eq=False)
class Greedy(AskTellOptimizer):
    """Push along the line from the centroid to the goal, where it also turns the object the right way.

    A push at lever arm a moves a body of radius of gyration l forwards and turns it by a / (a^2 + l^2) per
    metre (quasi-static pushing with an isotropic limit surface, Lynch & Mason 1996). Among all points of
    the effective contour the one with the lowest (1 - cos(angle to the goal)) + turn_weight |turn per metre
    - wanted| l is taken, the wanted turn being what is left of it over the distance left. It learns
    nothing.
    """

    parts: Components
    turn_weight: Annotated[float, Interval(ge=0, le=1e6)] = 1.0
    """How much a wrong turn counts against a wrong direction."""
    S0: ClassVar[int] = 0
    """No initial samples: it needs none."""

    def __post_init__(self) -> None:
        """Start without a design."""
        super().__init__(self.parts, 0)

    def ask(self, state: State | None = None) -> Proposal:
        """Choose the push for the object as it is now.

        Raises:
            ValueError: no state was given.
        """
        if state is None:
            raise ValueError("state: optimizer=greedy must see the object, call ask(state)")
        return super().ask(state)

    def _choose(self, state: State | None) -> Proposal:
        assert state is not None
        seen, target, line = state.seen, state.target, state.effective
        way = target.c - seen.c
        distance = float(np.linalg.norm(way))
        arms = line.points - seen.c
        normals = state.layout.inward(seen.contour)[line.index]
        radius = gyration(seen.contour - seen.c) / np.sqrt(2.0)
        lever = arms[:, 0] * normals[:, 1] - arms[:, 1] * normals[:, 0]
        turn = lever / (lever**2 + radius**2)
        left = -np.nan_to_num(target.turn_from(seen.theta))  # a round object has nothing left to turn
        lo, hi = self.history.outer.T
        wanted = left / max(distance, lo[1])
        off = 1.0 - normals @ way / max(distance, 1e-12)
        cost = off + self.turn_weight * radius * np.abs(turn - wanted)
        cost[(line.kappa < lo[0]) | (line.kappa > hi[0])] = np.inf
        u = np.clip([line.kappa[lowest(cost)], distance], lo, hi)
        return Proposal(u, "exploit", self.history.outer)
