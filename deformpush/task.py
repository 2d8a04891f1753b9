"""The goal, the errors (1)-(4), and when to stop."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Gt, Interval

from deformpush.cell.perception import MaskGrid, Observation
from deformpush.errors import UserError
from deformpush.mechanics.geometry import rotation, wrap

Array = np.ndarray


@dataclass(frozen=True)
class Errors:
    """Errors (1)-(4) and the same in a person's units."""

    e_c: float
    e_theta: float
    e_gamma: float
    e_T: float
    position_error_m: float
    angle_error_rad: float


@dataclass(frozen=True)
class Goal:
    """Where the object shall be, from where it starts."""

    offset: tuple[float, float]
    """From the start centroid to the goal centroid (m, table frame)."""
    turn_deg: float
    """Turn of the object, counter-clockwise (degrees)."""
    mask: tuple[Annotated[float, Gt(0)], Annotated[float, Gt(0)]] | None = None
    """Sides of a rectangular goal mask (m), first along the principal direction; None: shape at the start."""


@dataclass(frozen=True)
class Stop:
    """Stop values; an error at or under its stop value is reached."""

    position_m: Annotated[float, Gt(0)]
    angle_deg: Annotated[float, Gt(0)]
    e_gamma: Annotated[float, Gt(0)]
    on_damage: bool = False
    """End the run as damaged with the first push that strains the object beyond its limit."""

    @property
    def angle_rad(self) -> float:
        """The angle in radians."""
        return float(np.radians(self.angle_deg))


@dataclass(frozen=True)
class Weights:
    """Weights of the total error (4)."""

    k_c: Annotated[float, Gt(0)]
    k_theta: Annotated[float, Gt(0)]
    k_gamma: Annotated[float, Gt(0)]

    def total(self, e_c: Any, e_theta: Any, e_gamma: Any) -> Any:
        """e_T = k_c e_c + k_theta |e_theta| + k_gamma e_gamma (4), of numbers, arrays or tensors."""
        return self.k_c * e_c + self.k_theta * abs(e_theta) + self.k_gamma * e_gamma


@dataclass(frozen=True)
class Jitter:
    """Largest deviations drawn from the seed when the task is jittered (uniform)."""

    position_m: Annotated[float, Ge(0)]
    angle_deg: Annotated[float, Ge(0)]
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


@dataclass(frozen=True)
class Target:
    """The goal once the start is known: c_d, theta_d, gamma_d, and what e_c is divided by."""

    c: Array
    theta: float
    gamma: Array
    outline_body: Array
    """Outline of gamma_d `(G, 2)` about the origin, principal direction along x (m)."""
    length: float
    """Denominator of e_c (m)."""

    @property
    def outline(self) -> Array:
        """Outline of the goal mask at the goal pose (table frame)."""
        return self.outline_body @ rotation(self.theta).T + self.c


@dataclass(frozen=True)
class TotalError:
    """e_T (4) of a pose and a mask error, for arrays of numpy and tensors of torch alike."""

    goal_c: Array
    goal_theta: float
    length: float
    """Denominator of e_c (m)."""
    weights: Weights

    def __call__(self, x: Any, y: Any, theta: Any, e_gamma: Any) -> Any:
        """e_T at centroids x, y (m, table frame), angles theta (rad), mask errors e_gamma; same shapes."""
        goal_x, goal_y = self.goal_c.tolist()
        e_c = ((x - goal_x) ** 2 + (y - goal_y) ** 2) ** 0.5 / self.length
        turn = (theta - self.goal_theta + np.pi) % (2 * np.pi) - np.pi
        return self.weights.total(e_c, turn / np.pi, e_gamma)


@dataclass(frozen=True)
class Task:
    """What is wanted. Where the paper leaves a choice it is a switch here."""

    goal: Goal
    weights: Weights
    stop: Stop
    jitter: bool
    """Vary start pose, goal and material with the seed."""
    jitter_range: Jitter
    stop_when: Literal["all", "any"]
    """all: every error at or under its stop value. any: one suffices, as Algorithm 2 prints it."""
    e_c_over: Literal["start", "goal"]
    """e_c over the start distance |c_0 - c_d|, or over |c_d| as (1) prints it (depends on the origin)."""
    e_theta_sign: Literal["absolute", "signed"]
    """Stop on |e_theta|, or on the signed value as Algorithm 2 prints it."""

    def draw(self, rng: np.random.Generator) -> Draw:
        """The variation of this run: from the seed if `jitter`, otherwise none."""
        return self.jitter_range.draw(rng) if self.jitter else Draw()

    def target(self, start: Observation, grid: MaskGrid, draw: Draw) -> Target:
        """Fix the goal relative to the first observation.

        Raises:
            UserError: `goal.offset` leads nowhere while e_c is divided by the start distance.
        """
        c = start.c + self.goal.offset + draw.goal_shift
        length = float(np.linalg.norm(c if self.e_c_over == "goal" else start.c - c))
        if length < 1e-3:
            raise UserError(
                f"task.goal.offset = {list(self.goal.offset)}: puts the goal within 1 mm of the "
                + ("table origin" if self.e_c_over == "goal" else "start")
                + f", and e_c_over={self.e_c_over} divides by that distance; "
                "choose another offset or e_c_over"
            )
        if self.goal.mask is None:
            outline = (start.contour - start.c) @ rotation(-start.theta).T
        else:
            outline = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * self.goal.mask
        theta = start.theta + np.radians(self.goal.turn_deg + draw.goal_turn_deg)
        return Target(c, float(theta), grid.draw(outline), outline, length)

    def errors(self, seen: Observation, target: Target) -> Errors:
        """The errors of an observation.

        e_c = |c - c_d| / length (1);
        e_theta = (theta - theta_d) / pi, the difference taken into [-pi, pi) (2);
        e_gamma = sum(gamma xor gamma_d) / sum(gamma_d) (3);
        e_T = k_c e_c + k_theta |e_theta| + k_gamma e_gamma (4).
        """
        distance = float(np.linalg.norm(seen.c - target.c))
        turn = float(wrap(seen.theta - target.theta))
        e_c, e_theta = distance / target.length, turn / np.pi
        e_gamma = float(np.sum(seen.gamma ^ target.gamma) / np.sum(target.gamma))
        e_total = self.weights.total(e_c, e_theta, e_gamma)
        return Errors(e_c, e_theta, e_gamma, e_total, distance, turn)

    def total_error(self, target: Target) -> TotalError:
        """e_T as a function of where the object may come to lie."""
        return TotalError(target.c, target.theta, target.length, self.weights)

    def reached(self, errors: Errors) -> bool:
        """Whether the stop rule holds."""
        turn = abs(errors.angle_error_rad) if self.e_theta_sign == "absolute" else errors.angle_error_rad
        met = (
            errors.position_error_m <= self.stop.position_m,
            turn <= self.stop.angle_rad,
            errors.e_gamma <= self.stop.e_gamma,
        )
        return all(met) if self.stop_when == "all" else any(met)
