"""The straight line of a push and the speed along it: settings and geometry, the same in every engine."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Interval

from deformpush.cell.push import ToolPath

Array = np.ndarray


@dataclass(frozen=True)
class Motion:
    """How a push is executed."""

    speed: Annotated[float, Interval(ge=1e-3, le=10)]
    """Tool speed (m/s)."""
    acceleration: Annotated[float, Interval(ge=0.01, le=1000)]
    """Tool acceleration and deceleration (m/s^2)."""
    lead: Annotated[float, Interval(ge=1e-4, le=0.2)]
    """The tool is put down this far before the touch, clear of the object (m)."""
    clear: Annotated[float, Interval(ge=1e-4, le=0.2)]
    """On its way back the tool is lifted once the object is this far away from it (m)."""
    settle_speed: Annotated[float, Interval(ge=1e-6, le=10)]
    """The object is at rest when no node moves faster (m/s)."""
    settle_s: Annotated[float, Interval(ge=0, le=60)]
    """But no longer than this (s)."""
    frames: Annotated[int, Interval(ge=0, le=100)]
    """Instants of each push that are kept for the recording."""


class Line:
    """The part of a tool path that is executed in contact or near it."""

    def __init__(self, path: ToolPath, lead: float) -> None:
        self.origin = path.contact - lead * path.direction
        self.direction = path.direction
        self.length = lead + path.d

    def at(self, s: Array | float) -> Array:
        """Tool centre after travelling s (m): `(2,)` or `(P, 2)`."""
        return self.origin + np.multiply.outer(s, self.direction)


def ramp(length: float, speed: float, acceleration: float, dt: float) -> Array:
    """Distance and speed `(n, 2)` at the end of each step of a trapezoidal profile from rest to rest."""
    top = min(speed, np.sqrt(length * acceleration))
    rise = top / acceleration
    duration = length / top + rise
    t = np.arange(1, int(np.ceil(duration / dt)) + 1) * dt
    left = np.maximum(duration - t, 0.0)
    s = np.where(
        t < rise,
        acceleration * t**2 / 2,
        np.where(left < rise, length - acceleration * left**2 / 2, top * (t - rise / 2)),
    )
    return np.column_stack([s, np.diff(s, prepend=0.0) / dt])
