"""States of a rigid rectangle for optimizers that want to see the object."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from deformpush.cell.observation import Observation
from deformpush.cell.push import EffectiveContour, Push
from deformpush.mechanics.geometry import resample, rotation
from deformpush.task import TotalError, Weights

BODY = resample(np.array([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)]), 128)
ROUND = EffectiveContour(90.0, 450.0)
LAYOUT = Push(offset=0.02, augment="radial", tool_radius=0.01, contact_margin=0.0, clearance=0.004)
GOAL = TotalError(np.array([0.0, 0.2]), 0.0, 0.2, Weights(3.0, 3.0, 1.0))


@dataclass
class Seen:
    """What the protocol's State asks for."""

    contour: np.ndarray
    c: np.ndarray
    theta: float
    effective: np.ndarray
    e_gamma: float
    e_T_share: float
    paths: Any
    total_error: Any
    goal_c: np.ndarray
    goal_theta: float
    trials: Any = None
    strain: float = 0.05
    speed: float = 0.03


def seen(x=0.0, y=0.0, theta=0.0, e_gamma=0.02, body=BODY):
    """The rectangle at a pose, its goal at (0, 0.2), unturned."""
    c = np.array([x, y])
    contour = body @ rotation(theta).T + c
    first = int(np.argmin(np.abs(np.angle(np.exp(1j * (np.arctan2(*(contour - c).T[::-1]) - theta))))))
    at = Observation(np.roll(contour, -first, axis=0), c, theta, np.zeros((2, 2), bool), False)
    share = GOAL(x, y, theta, e_gamma) / GOAL(0.0, 0.0, 0.0, e_gamma)
    paths = partial(LAYOUT.paths, seen=at, part=ROUND)
    effective = LAYOUT.effective(at, ROUND)
    return Seen(at.contour, c, theta, effective, e_gamma, float(share), paths, GOAL, GOAL.goal_c, 0.0)
