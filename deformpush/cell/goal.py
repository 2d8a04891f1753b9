"""Where the object shall come to lie, from what was seen of it first."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Interval, MinLen

from deformpush.cell.observation import Observation
from deformpush.cell.orientation import by_registration
from deformpush.cell.ranges import Degrees, Place, Point, Side
from deformpush.mechanics.geometry import resample, rotation
from deformpush.mechanics.outline import simple
from deformpush.mechanics.rounding import METRES, rounded

Array = np.ndarray

Coordinate = Annotated[float, Interval(ge=-100, le=100)]


@dataclass(frozen=True)
class Placed:
    """A goal in the table frame."""

    c: Array
    """Centroid `(2,)` (m)."""
    theta: float
    """Angle (rad)."""
    body: Array
    """Outline of the goal shape `(G, 2)` in the object's frame (m)."""


@dataclass(frozen=True)
class Goal:
    """Where the object shall be: from where it starts, or at a pose, outline or picture instead."""

    offset: Place
    """From the start centroid to the goal centroid (m, table frame)."""
    turn_deg: Degrees
    """Turn of the object, counter-clockwise (degrees)."""
    mask: tuple[Side, Side] | None = None
    """Sides of a rectangular goal mask (m), first along the principal direction; None: shape at the start,
    or that of `outline`."""
    pose: tuple[Coordinate, Coordinate, Degrees] | None = None
    """Centroid (m, table frame), and angle of the principal direction (degrees): 0 along x."""
    outline: Annotated[tuple[Point, ...], MinLen(3)] | None = None
    """The object's outline at the goal (m, table frame)."""
    picture: str | None = None
    """File with a picture of the object at the goal, from the run's camera, which gives `outline`."""

    def __post_init__(self) -> None:
        if self.pose is not None and (self.outline is not None or self.picture is not None):
            raise ValueError("pose: says where the goal is, and so does outline or picture; leave one out")
        if self.outline is not None:
            simple(np.array(self.outline))

    @property
    def setting(self) -> str:
        """The setting that counts: key and value."""
        if self.picture is not None:
            return f"task.goal.picture = {self.picture}"
        if self.outline is not None:
            return f"task.goal.outline = {len(self.outline)} points"
        key = "offset" if self.pose is None else "pose"
        return f"task.goal.{key} = {list(getattr(self, key))}"

    def place(self, start: Observation, shift: tuple[float, float], turn_deg: float) -> Placed:
        """The goal, for an object that was seen first as `start`.

        Args:
            start: the first look.
            shift: added to `offset` (m); pose and outline are meant as they stand.
            turn_deg: added to `turn_deg`.
        """
        body = rounded(start.body, METRES)
        if self.outline is not None:
            contour = rounded(resample(simple(np.array(self.outline)).points, len(start.contour)), METRES)
            c = rounded(contour.mean(axis=0), METRES)
            theta = by_registration(contour, c, start.reference, start.theta)[1]
            body = rounded((contour - c) @ rotation(-theta).T, METRES)
        elif self.pose is not None:
            c, theta = np.array(self.pose[:2]), float(np.radians(self.pose[2]))
        else:
            c = start.c + self.offset + np.array(shift)
            theta = float(start.theta + np.radians(self.turn_deg + turn_deg))
        if self.mask is not None:
            body = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * self.mask
        return Placed(c, theta, body)
