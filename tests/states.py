"""States of a rigid rectangle for optimizers that want to see the object."""

from dataclasses import replace

import numpy as np

from deformpush.cell.effective import EffectiveContour
from deformpush.cell.observation import Observation
from deformpush.cell.push import Push
from deformpush.mechanics.geometry import resample, rotation, wrap
from deformpush.state import State
from deformpush.task import TERMS, TOTAL, Errors, Target, TotalError, Weights

BODY = resample(np.array([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)]), 128)
ROUND = EffectiveContour(90.0, 450.0)
LAYOUT = Push(offset=0.02, augment="radial", tool_radius=0.01, contact_margin=0.0, clearance=0.004)
WEIGHTS = Weights(3.0, 3.0, 1.0)
NO_MASK = np.zeros((2, 2), bool)
TARGET = Target(np.array([0.0, 0.2]), 0.0, NO_MASK, BODY, 0.2)
GOAL = TotalError(TARGET, WEIGHTS)


def errors(seen: Observation, shape: float, target: Target = TARGET) -> Errors:
    """The errors of an object at a pose, of this shape error (3)."""
    measured = (float(np.linalg.norm(seen.c - target.c)), float(wrap(seen.theta - target.theta)), shape)
    relative = [term.relative(x, target) for term, x in zip(TERMS, measured, strict=False)]
    values = {term.column: x for term, x in zip(TERMS, measured, strict=False)}
    values |= {term.symbol: x for term, x in zip(TERMS, relative, strict=False)}
    return Errors(values | {TOTAL.column: float(WEIGHTS.total(*relative))})


def observed(contour: np.ndarray, c: np.ndarray, theta: float) -> Observation:
    """An outline `(M, 2)` as perception has it: the first point lies in direction theta from c."""
    polar = np.arctan2(*(contour - c).T[::-1]) - theta
    first = int(np.argmin(np.abs(np.angle(np.exp(1j * polar)))))
    return Observation(np.roll(contour, -first, axis=0), c, theta, NO_MASK, False)


def known(
    seen: Observation, shape: float = 0.02, target: Target = TARGET, part: EffectiveContour = ROUND
) -> State:
    """What an optimizer may know of an observation on the way from the origin to a target."""
    start = errors(replace(seen, c=np.zeros(2), theta=0.0), shape, target).e_T
    now = errors(seen, shape, target)
    return State(seen, target, now, now.e_T / start, WEIGHTS, LAYOUT, part, speed=0.03, strain=0.05)


def seen(
    x: float = 0.0, y: float = 0.0, theta: float = 0.0, shape: float = 0.02, body: np.ndarray = BODY
) -> State:
    """The rectangle at a pose, its goal at (0, 0.2), unturned."""
    c = np.array([x, y])
    return known(observed(body @ rotation(theta).T + c, c, theta), shape)
