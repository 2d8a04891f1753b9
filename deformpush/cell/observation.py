"""What is known of the object at one instant: plain data."""

from dataclasses import dataclass, field

import numpy as np

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
