"""A cylinder that follows its path exactly, without an arm."""

from typing import Any

import numpy as np

from deformpush.cell.robot import BareTool
from deformpush.worlds.workspace import Workspace

Array = np.ndarray


class BareToolDrive(Workspace):
    """Moves the tool in one world."""

    def __init__(self, spec: BareTool, client: Any, radius: float) -> None:
        super().__init__(spec)
        self.client = client
        shape = client.createCollisionShape(client.GEOM_CYLINDER, radius=radius, height=spec.length)
        look = client.createVisualShape(
            client.GEOM_CYLINDER, radius=radius, length=spec.length, rgbaColor=[0.35, 0.35, 0.38, 1]
        )
        self.link = 1
        self._height = spec.tip_height + spec.length / 2
        self.id = client.createMultiBody(
            baseMass=0,
            basePosition=[0, 0, self._height],
            linkMasses=[1.0, 1.0],
            linkCollisionShapeIndices=[-1, shape],
            linkVisualShapeIndices=[-1, look],
            linkPositions=[[0, 0, 0]] * 2,
            linkOrientations=[[0, 0, 0, 1]] * 2,
            linkInertialFramePositions=[[0, 0, 0]] * 2,
            linkInertialFrameOrientations=[[0, 0, 0, 1]] * 2,
            linkParentIndices=[0, 1],
            linkJointTypes=[client.JOINT_PRISMATIC] * 2,
            linkJointAxis=[[1, 0, 0], [0, 1, 0]],
        )
        client.changeDynamics(self.id, self.link, lateralFriction=spec.friction)
        self._away = np.add(spec.centre, (0.0, 3.0))  # far from object and picture
        self.park()

    def place(self, xy: Array) -> None:
        """Put the tool there at rest, while it is clear of the object; costs no physics step."""
        self.follow(xy, np.zeros(2))

    def follow(self, xy: Array, velocity: Array) -> None:
        """For the coming step: be at `xy` (m), moving at `velocity` (m/s)."""
        for axis in (0, 1):
            self.client.resetJointState(self.id, axis, xy[axis], velocity[axis])
            self.client.setJointMotorControl2(
                self.id, axis, self.client.VELOCITY_CONTROL, targetVelocity=velocity[axis], force=1e4
            )

    def tip(self) -> Array:
        """Tool tip `(3,)` (m)."""
        x, y = (self.client.getJointState(self.id, axis)[0] for axis in (0, 1))
        return np.array([x, y, self.spec.tip_height])

    def park(self) -> None:
        """Take the tool out of the picture; costs no physics step."""
        self.place(self._away)
