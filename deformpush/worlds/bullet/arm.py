"""The Kuka iiwa with a cylindrical tool, and motors that follow a path."""

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from deformpush.cell.robot import KukaIiwa
from deformpush.worlds.arm.posture_path import Planner, PosturePath
from deformpush.worlds.bullet.engine import connect, quiet

Array = np.ndarray

_TOOL_URDF = """
  <link name="tool">
    <inertial><mass value="0.2"/><origin xyz="0 0 {middle}"/>
      <inertia ixx="2e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="1e-5"/></inertial>
    <visual><origin xyz="0 0 {middle}"/><geometry><cylinder radius="{radius}" length="{length}"/></geometry>
      <material name="tool_grey"><color rgba="0.35 0.35 0.38 1"/></material></visual>
    <collision><origin xyz="0 0 {middle}"/>
      <geometry><cylinder radius="{radius}" length="{length}"/></geometry></collision>
  </link>
  <joint name="tool_joint" type="fixed"><parent link="lbr_iiwa_link_7"/><child link="tool"/></joint>
  <link name="tool_tip"><inertial><mass value="0.001"/>
    <inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link>
  <joint name="tool_tip_joint" type="fixed"><origin xyz="0 0 {tip}"/>
    <parent link="tool"/><child link="tool_tip"/></joint>
</robot>
"""
_FLANGE = 0.045  # from the frame of link 7 to the face of the flange (m), in pybullet_data's model


class ArmDrive:
    """Moves the arm in one world."""

    def __init__(self, spec: KukaIiwa, client: Any, radius: float) -> None:
        self.spec, self.client = spec, client
        self._folder = tempfile.TemporaryDirectory(prefix="deformpush-arm-")
        self.urdf = str(_write_urdf(Path(self._folder.name) / "kuka_iiwa_tool.urdf", spec, radius))
        self._twin = _Twin(self.urdf)
        with quiet():
            self.id = client.loadURDF(self.urdf, useFixedBase=True)
        self._names = self._twin.joints
        self._tip, self.link = self._twin.links["tool_tip"], self._twin.links["tool"]
        client.changeDynamics(self.id, self.link, lateralFriction=spec.friction)
        self._planner = Planner(self._twin, spec)
        self._path: PosturePath | None = None
        self.park()

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` have a posture within the joint limits."""
        return self._planner.can_reach(points)

    def prepare(self, points: Array) -> None:
        """Plan postures along a path of tool positions `(P, 2)`, at most a few millimetres apart.

        Raises:
            WorldError: a point is out of reach, or a joint would flip on the way. Nothing has moved.
        """
        self._path = self._planner.plan(points)

    def place(self, xy: Array) -> None:
        """Put the arm there at rest, while it is clear of the object; costs no physics step."""
        self._set(self._posture(xy)[0])

    def follow(self, xy: Array, velocity: Array) -> None:
        """For the coming step: be at `xy` (m), moving at `velocity` (m/s), both on the prepared path."""
        posture, slope = self._posture(xy)
        self._drive(posture, slope[:, 0] * velocity[0] + slope[:, 1] * velocity[1])

    def tip(self) -> Array:
        """Tool tip `(3,)` (m)."""
        return np.array(self.client.getLinkState(self.id, self._tip, computeForwardKinematics=True)[4])

    def park(self) -> None:
        """Put the arm into its parking posture; costs no physics step."""
        self._set(np.array(self.spec.park))

    def joints(self) -> dict[str, float]:
        """Joint angles by URDF name (rad)."""
        return {n: self.client.getJointState(self.id, j)[0] for j, n in enumerate(self._names)}

    def close(self) -> None:
        """Free the twin and the folder of the tool's description."""
        self._twin.close()
        self._folder.cleanup()

    def _set(self, posture: Array) -> None:
        for j, q in enumerate(posture):
            self.client.resetJointState(self.id, j, q, 0.0)
        self._drive(posture, np.zeros(7))

    def _drive(self, posture: Array, velocity: Array) -> None:
        self.client.setJointMotorControlArray(
            self.id,
            range(7),
            self.client.POSITION_CONTROL,
            targetPositions=posture.tolist(),
            targetVelocities=velocity.tolist(),
            positionGains=[self.spec.gain] * 7,
            velocityGains=[1.0] * 7,
            forces=[self.spec.force] * 7,
        )

    def _posture(self, xy: Array) -> tuple[Array, Array]:
        assert self._path is not None, "prepare() comes first"
        return self._path.at(xy)


class _Twin:
    """The same arm in a client of its own, without physics: its kinematics."""

    def __init__(self, urdf: str) -> None:
        self._client = connect()
        with quiet():
            self._id = self._client.loadURDF(urdf, useFixedBase=True)
        infos = [self._client.getJointInfo(self._id, j) for j in range(self._client.getNumJoints(self._id))]
        self.joints = [i[1].decode() for i in infos[:7]]
        self.links = {i[12].decode(): i[0] for i in infos}
        self.low, self.high = (np.array([i[k] for i in infos[:7]]) for k in (8, 9))
        self._tip = self.links["tool_tip"]

    def tip(self, q: Array) -> tuple[Array, Array]:
        """See `Kinematics.tip`."""
        for j in range(7):
            self._client.resetJointState(self._id, j, q[j])
        state = self._client.getLinkState(self._id, self._tip, computeForwardKinematics=True)
        turn = np.array(self._client.getMatrixFromQuaternion(state[5])).reshape(3, 3)
        return np.array(state[4]), turn[:, 2]

    def jacobian(self, q: Array) -> Array:
        """See `Kinematics.jacobian`."""
        zeros = [0.0] * 7
        linear, angular = self._client.calculateJacobian(
            self._id, self._tip, [0, 0, 0], q.tolist(), zeros, zeros
        )
        return np.vstack([np.array(linear), np.array(angular)[:2]])

    def close(self) -> None:
        """Free the client."""
        self._client.disconnect()


def _write_urdf(path: Path, spec: KukaIiwa, radius: float) -> Path:
    """The library's arm with the tool on its flange; mesh files by absolute path."""
    import pybullet_data

    source = Path(pybullet_data.getDataPath()) / "kuka_iiwa" / "model.urdf"
    text = re.sub(r'filename="meshes/', f'filename="{source.parent.as_posix()}/meshes/', source.read_text())
    tool = _TOOL_URDF.format(
        radius=radius, length=spec.length, middle=_FLANGE + spec.length / 2, tip=_FLANGE + spec.length
    )
    path.write_text(text.replace("</robot>", tool))
    return path
