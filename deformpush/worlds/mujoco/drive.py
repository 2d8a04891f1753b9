"""What moves the tool in MuJoCo: directly, or along with the tip of an arm that is not simulated."""

import tempfile
from pathlib import Path
from typing import Protocol

import numpy as np

from deformpush.cell.robot import BareTool, KukaIiwa, Robot
from deformpush.mechanics.rounding import METRES, rounded
from deformpush.worlds.arm.iiwa import JOINTS, Iiwa
from deformpush.worlds.arm.posture_path import Planner, PosturePath
from deformpush.worlds.arm.urdf import urdf
from deformpush.worlds.drive import Drive
from deformpush.worlds.mujoco.simulation import MujocoSimulation
from deformpush.worlds.workspace import Workspace

Array = np.ndarray

AWAY = np.array([0.0, 10.0])
"""Where the tool is between pushes, far from object and picture (m)."""


class MujocoDrive(Drive, Protocol):
    """Moves the tool of one simulation."""

    posture: Array
    """Joint angles `(J,)` (rad), all that it has for a state beside the tool's place."""


def drive(robot: Robot, simulation: MujocoSimulation, tool_radius: float) -> MujocoDrive:
    """The drive of a robot.

    Raises:
        ValueError: there is none for it.
    """
    if isinstance(robot, BareTool):
        return BareToolDrive(robot, simulation)
    if isinstance(robot, KukaIiwa):
        return ArmDrive(robot, simulation, tool_radius)
    raise ValueError(f"has a BareTool or a KukaIiwa as its robot, and no {type(robot).__name__}")


class BareToolDrive(Workspace):
    """`robot=tool`."""

    def __init__(self, spec: BareTool, simulation: MujocoSimulation) -> None:
        super().__init__(spec)
        self._simulation = simulation
        self.posture = np.empty(0)
        self.park()

    def place(self, xy: Array) -> None:
        """Put the tool there at rest."""
        self._simulation.move_tool(xy, np.zeros(2))

    def follow(self, xy: Array, velocity: Array) -> None:
        """For the coming step: be at `xy` (m), moving at `velocity` (m/s)."""
        self._simulation.move_tool(xy, velocity)

    def tip(self) -> Array:
        """Tool tip `(3,)` (m)."""
        return np.append(self._simulation.tool_at(), self.spec.tip_height)

    def park(self) -> None:
        """Take the tool out of the picture."""
        self.place(AWAY)


class ArmDrive:
    """`robot=kuka_iiwa`: the tool is where the arm's tip is; no force turns its joints."""

    def __init__(self, spec: KukaIiwa, simulation: MujocoSimulation, tool_radius: float) -> None:
        self._spec, self._simulation, self._radius = spec, simulation, tool_radius
        self._arm = Iiwa(spec.length)
        self._planner = Planner(self._arm, spec)
        self._path: PosturePath | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self.park()

    @property
    def urdf(self) -> str:
        """File of the arm, written when it is first asked for."""
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="deformpush-arm-")
        file = Path(self._folder.name) / "kuka_iiwa_tool.urdf"
        if not file.exists():
            file.write_text(urdf(self._spec.length, self._radius), encoding="utf-8")
        return str(file)

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
        """Put the arm there at rest."""
        self.follow(xy, np.zeros(2))

    def follow(self, xy: Array, velocity: Array) -> None:
        """For the coming step: be at `xy` (m), moving at `velocity` (m/s), both on the prepared path."""
        assert self._path is not None, "prepare() comes first"
        dt = self._simulation.dt
        before, self.posture = (self._path.at(place)[0] for place in (xy, xy + velocity * dt))
        start, end = (rounded(self._arm.tip(posture)[0][:2], METRES) for posture in (before, self.posture))
        self._simulation.move_tool(start, (end - start) / dt)

    def tip(self) -> Array:
        """Tool tip `(3,)` (m): where the simulation has the tool, as high as the arm holds it."""
        return np.append(self._simulation.tool_at(), self._arm.tip(self.posture)[0][2])

    def park(self) -> None:
        """Put the arm into its parking posture and the tool away."""
        self.posture = np.array(self._spec.park)
        self._simulation.move_tool(AWAY, np.zeros(2))

    def joints(self) -> dict[str, float]:
        """Joint angles by URDF name (rad)."""
        return {joint.name: float(q) for joint, q in zip(JOINTS, self.posture, strict=True)}

    def close(self) -> None:
        """Free the folder of the arm's description."""
        if self._folder is not None:
            self._folder.cleanup()
