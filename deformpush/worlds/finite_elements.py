"""What worlds with a finite element engine have in common: all but the engine, the drive and the picture."""

from typing import Protocol

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.world import Outcome, Scenery, World
from deformpush.mechanics.mesh import TetMesh
from deformpush.worlds.drive import Drive
from deformpush.worlds.push_execution import PushExecution, Simulation
from deformpush.worlds.tool_motion import Motion

Array = np.ndarray

TABLE_THICKNESS = 0.05
"""Metres."""


class Settings(Protocol):
    """What every such world is told."""

    @property
    def margin(self) -> float:
        """The object floats this high and is touched this far outside its surface (m)."""

    @property
    def motion(self) -> Motion:
        """How a push is executed."""

    @property
    def table(self) -> tuple[float, float, float, float]:
        """Middle x, y and half lengths x, y of the table (m)."""


class FiniteElementWorld(World):
    """One object on one table, in one engine."""

    def __init__(
        self,
        settings: Settings,
        sheet: SoftObject,
        camera: Camera,
        tool_radius: float,
        mesh: TetMesh,
        simulation: Simulation,
        tool: Drive,
    ) -> None:
        """Take over what a subclass has put up, and let the object come to rest."""
        self.camera, self.mesh, self.margin = camera, mesh, settings.margin
        self.simulation, self.tool = simulation, tool
        self.strain_limit, self.force_limit = sheet.strain_limit, sheet.force_limit
        self._table, self._triangles = settings.table, mesh.surface()
        self.execution = PushExecution(simulation, tool, mesh, settings.motion, tool_radius)
        self.execution.settle(Outcome(), at_least=0.1)

    def push(self, path: ToolPath) -> Outcome:
        """Push along the path and come back; see `World.push`."""
        outcome = self.execution.push(path, self.camera.rate, self.strain_limit)
        outcome.force_limit = self.force_limit
        return outcome

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` the tool can take."""
        return self.tool.can_reach(points)

    def nodes(self) -> Array:
        """Mesh nodes `(N, 3)` (m)."""
        return self.simulation.nodes()

    def strain(self) -> Array:
        """Largest strain at each mesh node `(N,)` (-)."""
        rest = self.execution.rest
        return rest.at_nodes(rest.strain(self.nodes()))

    def joints(self) -> dict[str, float]:
        """Arm joint angles (rad)."""
        return self.tool.joints()

    def scenery(self) -> Scenery:
        """What a recorder may draw."""
        x, y, hx, hy = self._table
        return Scenery(
            table_centre=(x, y, -TABLE_THICKNESS / 2),
            table_half_size=(hx, hy, TABLE_THICKNESS / 2),
            mesh_triangles=self._triangles,
            arm_urdf=self.tool.urdf,
        )

    def close(self) -> None:
        """Free what the tool holds."""
        self.tool.close()
