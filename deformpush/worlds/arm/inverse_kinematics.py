"""Postures of an arm whose tool stands upright with its tip at a given place."""

from typing import Protocol

import numpy as np

Array = np.ndarray

PLACED_M = 5e-5
"""The tip is where it should be when no coordinate is farther off."""
UPRIGHT = 1e-3
"""The tool is upright when its axis is tilted no further, about x and about y (rad)."""


class Kinematics(Protocol):
    """Where an arm's tip is, and how it moves with the seven joints."""

    low: Array
    """Joint limits `(7,)` (rad)."""
    high: Array
    """Joint limits `(7,)` (rad)."""

    def tip(self, q: Array) -> tuple[Array, Array]:
        """Tip `(3,)` (m) in posture q `(7,)`, and the unit vector `(3,)` along the tool towards it."""

    def jacobian(self, q: Array) -> Array:
        """How the tip moves `(3, 7)` (m/rad) over how the tool turns about x and y `(2, 7)` (rad/rad)."""


def upright_posture(
    arm: Kinematics, target: Array, seed: Array, rest: Array, iterations: int = 60
) -> Array | None:
    """A posture `(7,)` with the tool upright and its tip at `target` `(3,)` (m), within the joint limits.

    Damped least squares for the five coordinates that matter, from `seed`; the two that are free drift
    towards `rest`. None where it does not get there.
    """
    q = seed.copy()
    for _ in range(iterations):
        tip, axis = arm.tip(q)
        tilt = np.cross(axis, (0.0, 0.0, -1.0))
        if axis[2] > 0:  # more than a right angle off: turn at full rate
            tilt /= max(np.linalg.norm(tilt), 1e-9)
        error = np.concatenate([target - tip, tilt[:2]])
        if np.abs(error[:3]).max() < PLACED_M and np.abs(error[3:]).max() < UPRIGHT:
            inside = np.all((q >= arm.low) & (q <= arm.high))
            return q if inside else None
        jacobian = arm.jacobian(q)
        inverse = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T + 1e-5 * np.eye(5))
        step = inverse @ error + 0.1 * (np.eye(7) - inverse @ jacobian) @ (rest - q)
        q = np.clip(q + step * min(1.0, 0.3 / np.abs(step).max()), arm.low, arm.high)
    return None
