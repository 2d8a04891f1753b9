"""The goal, the errors (1)-(4) as one table, and when to stop."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from annotated_types import Interval

from deformpush.cell.goal import Goal
from deformpush.cell.observation import Observation
from deformpush.cell.variation import Draw, Jitter
from deformpush.errors import UserError
from deformpush.mechanics.geometry import rotation, wrap
from deformpush.mechanics.registration import ROUND
from deformpush.mechanics.rounding import length

if TYPE_CHECKING:
    from deformpush.cell.mask import MaskGrid

Array = np.ndarray


@dataclass(frozen=True)
class Quantity:
    """A column of pushes.csv as people read it."""

    name: str
    """One word."""
    symbol: str
    """The paper's, as a column is named."""
    tex: str
    unit: str
    column: str
    """Of pushes.csv, in SI units."""
    scale: float
    """From SI to the unit."""
    digits: int
    colour: tuple[int, int, int]
    """Of its line in every figure and recording (RGB, after Okabe and Ito)."""

    @property
    def label(self) -> str:
        """Name with unit, for an axis."""
        return f"{self.name} error ({self.unit})"

    def show(self, value: float) -> str:
        """A value, given in the unit, with it; nan is an error that the object does not have."""
        return "none" if np.isnan(value) else f"{value:.{self.digits}f} {self.unit}".removesuffix(" -")


@dataclass(frozen=True)
class ErrorTerm(Quantity):
    """One of the errors that e_T (4) adds up."""

    measured: Callable[[Observation, "Target"], float]
    """In SI units, with its sign."""
    relative: Callable[[float, "Target"], float]
    """The error (-) that a measured value comes to."""
    signed: bool
    weight: str
    """Its weight: a field of `Weights`."""
    stop: str
    """Its stop value: a field of `Stop`."""
    stop_scale: float
    """From the stop value to SI."""


TERMS = (
    ErrorTerm(
        name="position",
        symbol="e_c",
        tex="$e_c$",
        unit="mm",
        column="position_error_m",
        scale=1e3,
        digits=1,
        colour=(0, 114, 178),
        measured=lambda seen, target: length(seen.c - target.c),
        relative=lambda distance, target: distance / target.length,  # (1)
        signed=False,
        weight="k_c",
        stop="position_m",
        stop_scale=1.0,
    ),
    ErrorTerm(
        name="angle",
        symbol="e_theta",
        tex=r"$e_\theta$",
        unit="deg",
        column="angle_error_rad",
        scale=180 / np.pi,
        digits=1,
        colour=(213, 94, 0),
        measured=lambda seen, target: target.turn_from(seen.theta),
        relative=lambda turn, target: turn / np.pi,  # (2)
        signed=True,
        weight="k_theta",
        stop="angle_deg",
        stop_scale=np.pi / 180,
    ),
    ErrorTerm(
        name="shape",
        symbol="e_gamma",
        tex=r"$e_\gamma$",
        unit="-",
        column="e_gamma",
        scale=1.0,
        digits=3,
        colour=(0, 158, 115),
        measured=lambda seen, target: float(np.sum(seen.gamma ^ target.gamma) / np.sum(target.gamma)),
        relative=lambda share, target: share,  # (3)
        signed=False,
        weight="k_gamma",
        stop="e_gamma",
        stop_scale=1.0,
    ),
)
"""The errors (1)-(3). Whatever computes, weighs, stops on, records, draws or prints them reads this table."""
SHAPE = TERMS[2]
TOTAL = Quantity("total", "e_T", "$e_T$", "-", "e_T", 1.0, 3, (130, 130, 130))
ERROR_COLUMNS = (
    *(term.symbol for term in TERMS),
    TOTAL.symbol,
    *(term.column for term in TERMS if term.column != term.symbol),
)
"""Of pushes.csv and summary.json, in this order."""


@dataclass(frozen=True)
class Errors:
    """The errors of one observation, by column: relative ones, their sum e_T, measured ones in SI units."""

    values: dict[str, float]

    def __getitem__(self, column: str) -> float:
        return self.values[column]

    @property
    def e_T(self) -> float:
        """Total error (4)."""
        return self.values[TOTAL.column]

    def size(self, quantity: Quantity) -> float:
        """How large an error is, in its unit."""
        return abs(self.values[quantity.column]) * quantity.scale


@dataclass(frozen=True)
class Stop:
    """Stop values; an error at or under its stop value is reached."""

    position_m: Annotated[float, Interval(gt=0, le=10)]
    angle_deg: Annotated[float, Interval(gt=0, le=360)]
    e_gamma: Annotated[float, Interval(gt=0, le=10)]
    on_damage: bool = False
    """End the run as damaged with the first push that goes beyond a limit of the object."""

    def value(self, term: ErrorTerm) -> float:
        """The stop value of an error, in SI units."""
        return float(getattr(self, term.stop) * term.stop_scale)


@dataclass(frozen=True)
class Weights:
    """Weights of the total error (4)."""

    k_c: Annotated[float, Interval(ge=1e-6, le=1e6)]
    k_theta: Annotated[float, Interval(ge=1e-6, le=1e6)]
    k_gamma: Annotated[float, Interval(ge=1e-6, le=1e6)]

    def total(self, *errors: Any) -> Any:
        """e_T = k_c e_c + k_theta |e_theta| + k_gamma e_gamma (4); errors left out at the end count as 0."""
        total: Any = 0.0
        for term, error in zip(TERMS, errors, strict=False):  # not sum(), whose last bit differs by Python
            total = total + getattr(self, term.weight) * (abs(error) if term.signed else error)
        return total


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
    order: int = 1
    """Turns by 1 / order of a circle look alike; `ROUND`: all do."""

    def turn_from(self, theta: float) -> float:
        """How far an object at angle theta is turned from the goal (rad); nan where it has no angle."""
        return float(wrap(theta - self.theta, self.order)) if self.order != ROUND else np.nan

    @property
    def outline(self) -> Array:
        """Outline of the goal mask at the goal pose (table frame)."""
        return self.outline_body @ rotation(self.theta).T + self.c


@dataclass(frozen=True)
class TotalError:
    """e_T (4) of where the object may come to lie; errors that no model forecasts stay, and are left out."""

    target: Target
    weights: Weights

    def __call__(self, x: Array, y: Array, theta: Array, shape: Array) -> Array:
        """e_T at centroids x, y (m, table frame), angles theta (rad), shape errors (3); same shapes."""
        return self._from_goal(x, y, theta, shape)[0]

    def gradient(self, x: Array, y: Array, theta: Array, shape: Array) -> tuple[Array, Array]:
        """The same, and its slopes `(4, ...)` by x, y, theta and shape: at the goal, a kink, 0."""
        value, off_x, off_y, distance, turn = self._from_goal(x, y, theta, shape)
        steep = self.weights.k_c / (self.target.length * np.where(distance > 0.0, distance, np.inf))
        by_theta = self.weights.k_theta / np.pi * np.sign(turn)
        return value, np.stack([steep * off_x, steep * off_y, by_theta, self.weights.k_gamma + 0 * value])

    def _from_goal(self, x: Array, y: Array, theta: Array, shape: Array) -> tuple[Array, ...]:
        """e_T, and how far off it is: in x, in y, altogether (m), and turned (rad)."""
        goal = self.target
        off_x, off_y, turn = x - goal.c[0], y - goal.c[1], theta - goal.theta
        distance, period = np.sqrt(off_x**2 + off_y**2), 2 * np.pi / max(goal.order, 1)
        turn = turn - period * np.rint(turn / period) if goal.order != ROUND else 0 * turn
        value = self.weights.total(distance / goal.length, turn / np.pi, shape)
        return np.asarray(value), off_x, off_y, distance, turn


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

    def target(self, start: Observation, grid: "MaskGrid", draw: Draw) -> Target:
        """Fix the goal relative to the first observation.

        Raises:
            UserError: the goal is where the object is while e_c is divided by the start distance, or a
            picture that nobody has looked at.
        """
        if self.goal.picture is not None and self.goal.outline is None:
            raise UserError(
                f"{self.goal.setting}: not looked at yet, which make_run does; or give the outline"
            )
        goal = self.goal.place(start, draw.goal_shift, draw.goal_turn_deg)
        distance = length(goal.c if self.e_c_over == "goal" else start.c - goal.c)
        if distance < 1e-3:
            raise UserError(
                f"{self.goal.setting}: puts the goal within 1 mm of the "
                + ("table origin" if self.e_c_over == "goal" else "start")
                + f", and e_c_over={self.e_c_over} divides by that distance; "
                "choose another goal or e_c_over"
            )
        gamma = grid.draw(goal.body)
        return Target(goal.c, goal.theta, gamma, goal.body, distance, start.reference.order)

    def errors(self, seen: Observation, target: Target) -> Errors:
        """The errors (1)-(4) of an observation; that of the angle is nan where a round object has none."""
        measured = {term.column: term.measured(seen, target) for term in TERMS}
        relative = {term.symbol: term.relative(measured[term.column], target) for term in TERMS}
        counted = (0.0 if np.isnan(error) else error for error in relative.values())
        values = {**measured, **relative, TOTAL.column: self.weights.total(*counted)}
        return Errors({column: values[column] for column in ERROR_COLUMNS})

    def reached(self, errors: Errors) -> bool:
        """Whether the stop rule holds; an error that is nan does not count."""
        keep_sign = self.e_theta_sign == "signed"
        met = (
            (errors[t.column] if keep_sign else abs(errors[t.column])) <= self.stop.value(t)
            for t in TERMS
            if not np.isnan(errors[t.column])
        )
        return all(met) if self.stop_when == "all" else any(met)
