"""The Kuka LBR iiwa 14 R820 with a straight tool on its flange: dimensions, limits, forward kinematics.

Dimensions and limits are those of KUKA's data sheet. All joint axes of one half of the arm meet in a point:
shoulder, elbow and wrist. In the posture zero the arm stands upright, and every frame is that of the base.
"""

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Joint:
    """One revolute joint."""

    name: str
    offset: float
    """Height above the joint before it in posture zero (m)."""
    axis: tuple[int, int, int]
    """Unit vector in the frame before it."""
    limit_deg: float
    """It turns this far, both ways (degrees)."""


JOINTS = (
    Joint("iiwa_joint_1", 0.0, (0, 0, 1), 170.0),
    Joint("iiwa_joint_2", 0.36, (0, 1, 0), 120.0),
    Joint("iiwa_joint_3", 0.0, (0, 0, 1), 170.0),
    Joint("iiwa_joint_4", 0.42, (0, -1, 0), 120.0),
    Joint("iiwa_joint_5", 0.0, (0, 0, 1), 170.0),
    Joint("iiwa_joint_6", 0.40, (0, 1, 0), 120.0),
    Joint("iiwa_joint_7", 0.0, (0, 0, 1), 175.0),
)
FLANGE = 0.126
"""From the wrist to the face of the flange (m)."""


class Iiwa:
    """Kinematics of the arm; its base is the origin of the table frame."""

    def __init__(self, tool_length: float) -> None:
        self.high = np.radians([joint.limit_deg for joint in JOINTS])
        self.low = -self.high
        self._reach = FLANGE + tool_length

    def tip(self, q: Array) -> tuple[Array, Array]:
        """Tip `(3,)` (m) in posture q `(7,)`, and the unit vector `(3,)` along the tool towards it."""
        _, _, tip, along = self._chain(q)
        return tip, along

    def jacobian(self, q: Array) -> Array:
        """How the tip moves `(3, 7)` (m/rad) over how the tool turns about x and y `(2, 7)` (rad/rad)."""
        origins, axes, tip, _ = self._chain(q)
        (ax, ay, az), (rx, ry, rz) = axes.T, (tip - origins).T
        return np.stack([ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx, ax, ay])

    def _chain(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Origins and axes of the joints, each `(7, 3)`, the tip and the tool's direction, each `(3,)`."""
        turn, place = np.eye(3), np.zeros(3)
        origins, axes = np.empty((7, 3)), np.empty((7, 3))
        for i, (joint, c, s) in enumerate(zip(JOINTS, np.cos(q), np.sin(q), strict=True)):
            place = place + joint.offset * turn[:, 2]
            origins[i], axes[i] = place, turn @ joint.axis
            if joint.axis[2]:
                turn = turn @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            else:
                s *= joint.axis[1]
                turn = turn @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        return origins, axes, place + self._reach * turn[:, 2], turn[:, 2]
