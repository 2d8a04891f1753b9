"""The Kuka iiwa with a cylindrical tool: inverse kinematics, and motors that follow a path."""

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from deformpush.cell.robot import KukaIiwa
from deformpush.cell.world import WorldError
from deformpush.mechanics.rounding import JOINTS, length, rounded
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
    """Moves the arm in one world. Inverse kinematics run on a twin in its own client, without physics."""

    def __init__(self, spec: KukaIiwa, client: Any, radius: float) -> None:
        self.spec, self.client = spec, client
        self._folder = tempfile.TemporaryDirectory(prefix="deformpush-arm-")
        self.urdf = str(_write_urdf(Path(self._folder.name) / "kuka_iiwa_tool.urdf", spec, radius))
        self._twin = connect()
        with quiet():
            self.id, self._twin_id = (c.loadURDF(self.urdf, useFixedBase=True) for c in (client, self._twin))
        infos = [client.getJointInfo(self.id, j) for j in range(client.getNumJoints(self.id))]
        self._names = [i[1].decode() for i in infos[:7]]
        self._low, self._high = (np.array([i[k] for i in infos[:7]]) for k in (8, 9))
        links = {i[12].decode(): i[0] for i in infos}
        self._tip = links["tool_tip"]
        self.link = links["tool"]
        client.changeDynamics(self.id, self.link, lateralFriction=spec.friction)
        self._path: tuple[Array, Array] | None = None
        self.park()

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` have a posture within the joint limits."""
        return np.array([self._solve(p, np.array(self.spec.rest)) is not None for p in np.asarray(points)])

    def prepare(self, points: Array) -> None:
        """Plan postures along a path of tool positions `(P, 2)`, at most a few millimetres apart.

        Raises:
            WorldError: a point is out of reach, or a joint would flip on the way. Nothing has moved.
        """
        postures, seed = [], np.array(self.spec.rest)
        for point in points:
            posture = self._solve(point, seed)
            if posture is None:
                raise WorldError(
                    f"the arm cannot reach ({point[0]:.3f}, {point[1]:.3f}) m with the tool upright"
                )
            seed = rounded(posture, JOINTS)
            postures.append(seed)
        q = np.array(postures)
        turn = np.abs(np.diff(q, axis=0)).max(initial=0.0)
        if turn > self.spec.max_turn:
            raise WorldError(
                f"the arm would flip: a joint turns {np.degrees(turn):.0f} degrees within one step"
            )
        self._path = np.asarray(points), q

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
        self._twin.disconnect()
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
        """Posture at a point of the prepared path, and its slope dq/dxy along it `(7, 2)`."""
        assert self._path is not None, "prepare() comes first"
        points, q = self._path
        chord = points[-1] - points[0]
        whole = length(chord)
        along = np.linspace(0.0, whole, len(q))
        done = xy - points[0]
        s = float(np.clip((done[0] * chord[0] + done[1] * chord[1]) / whole, 0.0, whole))
        i = min(int(np.searchsorted(along, s, side="right")) - 1, len(q) - 2)
        slope = (q[i + 1] - q[i]) / (along[i + 1] - along[i])
        return q[i] + slope * (s - along[i]), np.outer(slope, chord / whole)

    def _solve(self, xy: Array, seed: Array, iterations: int = 60) -> Array | None:
        """Damped least squares for tip position and upright tool; the two free dimensions drift to `rest`."""
        twin, q, rest = self._twin, seed.copy(), np.array(self.spec.rest)
        target = np.array([xy[0], xy[1], self.spec.tip_height])
        zeros = [0.0] * 7
        for _ in range(iterations):
            for j in range(7):
                twin.resetJointState(self._twin_id, j, q[j])
            state = twin.getLinkState(self._twin_id, self._tip, computeForwardKinematics=True)
            axis = np.array(twin.getMatrixFromQuaternion(state[5])).reshape(3, 3)[:, 2]
            tilt = np.cross(axis, (0.0, 0.0, -1.0))
            if axis[2] > 0:  # more than a right angle off: turn at full rate
                tilt /= max(np.linalg.norm(tilt), 1e-9)
            error = np.concatenate([target - state[4], tilt[:2]])
            if np.abs(error[:3]).max() < 5e-5 and np.abs(error[3:]).max() < 1e-3:
                inside = np.all((q >= self._low) & (q <= self._high))
                return q if inside else None
            linear, angular = twin.calculateJacobian(
                self._twin_id, self._tip, [0, 0, 0], q.tolist(), zeros, zeros
            )
            jacobian = np.vstack([np.array(linear), np.array(angular)[:2]])
            inverse = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T + 1e-5 * np.eye(5))
            step = inverse @ error + 0.1 * (np.eye(7) - inverse @ jacobian) @ (rest - q)
            q = np.clip(q + step * min(1.0, 0.3 / np.abs(step).max()), self._low, self._high)
        return None


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
