"""What is known of the object at one instant: plain data."""

from dataclasses import dataclass, field

import numpy as np

from deformpush.mechanics.geometry import rotation

Array = np.ndarray


@dataclass(frozen=True)
class Observation:
    """What is known of the object at one instant (table frame, metres, radians)."""

    contour: Array
    """V_c `(M, 2)`, counter-clockwise, evenly spaced; the first point lies in direction theta from c."""
    c: Array
    """Centroid `(2,)`."""
    theta: float
    """Orientation, continuous in time (not wrapped)."""
    gamma: Array
    """Mask `(H, W)` bool of R(-theta) V_b."""
    compact: bool
    """True where PCA was ill-posed and theta was carried over by matching contours."""
    first: "FirstLook | None" = None
    """What was seen first; None where this is it."""

    @property
    def body(self) -> Array:
        """The contour in the object's frame `(M, 2)`: about its centroid, turned back by theta."""
        return (self.contour - self.c) @ rotation(-self.theta).T

    @property
    def reference(self) -> "FirstLook":
        """What was seen first; this, if nothing was before, and no symmetry is known."""
        return self.first or FirstLook(self.body, 1, self.c, self.theta)


@dataclass(frozen=True, eq=False)
class FirstLook:
    """What later looks are compared with."""

    body: Array
    """The contour then, in the object's frame `(M, 2)` (m)."""
    order: int
    """Turns by 1 / order of a circle look alike; `registration.ROUND`: all turns do."""
    c: Array
    """Centroid then `(2,)` (m, table frame)."""
    theta: float
    """Orientation then (rad)."""
    followed: bool = False
    """Whether point i of every later contour is where point i of this one came to lie."""


@dataclass(frozen=True)
class View:
    """What was to be seen between two pushes, and what was made of it."""

    picture: Array
    """RGB `(H, W, 3)` uint8."""
    seen: Observation
    nodes: Array | None = None
    """Mesh nodes `(N, 3)` (m); None where the world has no mesh."""
    joints: dict[str, float] = field(default_factory=dict)
    """Arm joint angles by URDF joint name (rad), empty without an arm."""
    strain: Array | None = None
    """Largest strain at each mesh node `(N,)` (-); None where the world does not measure it."""
