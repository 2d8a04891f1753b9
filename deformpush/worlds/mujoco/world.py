"""The MuJoCo world: soft slab, table, tool, the camera below, and its states."""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.rasteriser import draw
from deformpush.cell.robot import Robot
from deformpush.cell.world import WorldError
from deformpush.worlds.finite_elements import FiniteElementWorld
from deformpush.worlds.mujoco.drive import MujocoDrive, drive
from deformpush.worlds.mujoco.model import ToolShape, build_model, rest_nodes
from deformpush.worlds.mujoco.settings import Mujoco
from deformpush.worlds.mujoco.simulation import MujocoSimulation
from deformpush.worlds.push_execution import PushExecution
from deformpush.worlds.saved_state import Scene

Array = np.ndarray


class MujocoWorld(FiniteElementWorld):
    """One object on one table, in one model of MuJoCo."""

    offers = frozenset({"strain", "film", "branches", "states", "force"})

    simulation: MujocoSimulation
    tool: MujocoDrive

    def __init__(
        self, spec: Mujoco, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float
    ) -> None:
        if robot.tip_height > spec.margin:
            raise ValueError(
                f"robot.tip_height = {robot.tip_height:g} must not exceed world.margin = {spec.margin:g}: "
                "the tool here is straight from above the object to below it"
            )
        mesh = sheet.slab.mesh
        self._motion, self._robot, self._tool_radius = spec.motion, robot, tool_radius
        self._rgb = sheet.rgb
        friction = robot.friction * sheet.material.friction
        shape = ToolShape(tool_radius, robot.tip_height + robot.length, friction)
        model = build_model(mesh, sheet, spec.engine, spec.margin, shape)
        rest = rest_nodes(mesh, sheet, spec.margin)
        simulation = MujocoSimulation(model, rest, spec.engine.check_every)
        tool = drive(robot, simulation, tool_radius)
        super().__init__(spec, sheet, camera, tool_radius, mesh, simulation, tool)

    def picture(self) -> Array:
        """Picture from below, mirrored so that it reads like a map of the table seen from above."""
        return self._draw(self.nodes())

    def pictures_after(self, paths: Sequence[ToolPath]) -> list[Array | None]:
        """The picture after each of these pushes, each from a copy of the state, on all cores."""
        with ThreadPoolExecutor(os.cpu_count() or 1) as threads:  # a step runs outside of Python's lock
            return list(threads.map(self._picture_after, paths))

    def save(self) -> bytes:
        """The state of object, tool and arm; see `World.save`."""
        return self._scene.pack(np.concatenate([self.tool.posture, self.simulation.state()]))

    def restore(self, state: bytes) -> None:
        """Return to a state; see `World.restore`.

        Raises:
            ValueError: it is no state, a damaged one, or that of another world. Nothing has changed.
        """
        joints = len(self.tool.posture)
        numbers = self._scene.unpack(state, joints + len(self.simulation.state()))
        before = self.simulation.state()
        self.simulation.set_state(numbers[joints:])
        try:
            self.execution.guard.check(self.nodes())
        except WorldError as problem:
            self.simulation.set_state(before)
            raise ValueError(f"a damaged state: {problem}") from problem
        self.tool.posture = numbers[:joints]

    @cached_property
    def _scene(self) -> Scene:
        return Scene("mujoco", *self.simulation.description(), repr(self._robot).encode())

    def _picture_after(self, path: ToolPath) -> Array | None:
        simulation = self.simulation.branch()
        tool = drive(self._robot, simulation, self._tool_radius)
        trial = PushExecution(simulation, tool, self.mesh, self._motion, self._tool_radius)
        try:
            trial.push_unmeasured(path)
        except WorldError:
            return None
        return self._draw(simulation.nodes())

    def _draw(self, nodes: Array) -> Array:
        return self.camera.through_lens(draw(nodes, self._triangles, self.camera, self._rgb))
