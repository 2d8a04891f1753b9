"""How the seed varies a task: start pose, goal and material."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Interval

from deformpush.cell.object import SoftObject


@dataclass(frozen=True)
class Jitter:
    """Largest deviations drawn from the seed when the task is jittered (uniform)."""

    position_m: Annotated[float, Interval(ge=0, le=1)]
    angle_deg: Annotated[float, Interval(ge=0, le=360)]
    material: Annotated[float, Interval(ge=0, lt=1)]
    """Relative change of stiffness, friction and mass."""

    def draw(self, rng: np.random.Generator) -> "Draw":
        """Draw one variation of start pose, goal and material."""
        pose, goal = (rng.uniform(-self.position_m, self.position_m, 2) for _ in range(2))
        turns = rng.uniform(-self.angle_deg, self.angle_deg, 2)
        factors = 1 + rng.uniform(-self.material, self.material, 3)
        return Draw(tuple(pose), float(turns[0]), tuple(goal), float(turns[1]), tuple(factors))


@dataclass(frozen=True)
class Draw:
    """One variation of a task; the default is none."""

    start_shift: tuple[float, float] = (0.0, 0.0)
    start_turn_deg: float = 0.0
    goal_shift: tuple[float, float] = (0.0, 0.0)
    goal_turn_deg: float = 0.0
    material: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Factors on Young's modulus, friction and mass."""


def vary(sheet: SoftObject, draw: Draw) -> SoftObject:
    """The object as a variation of the task has it."""
    x, y = sheet.start
    dx, dy = draw.start_shift
    stiffness, friction, mass = draw.material
    return replace(
        sheet,
        start=(x + dx, y + dy),
        start_deg=sheet.start_deg + draw.start_turn_deg,
        material=sheet.material.scaled(stiffness, friction, mass),
    )
