"""The PyBullet world: soft slab, table, tool, and the camera below."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from annotated_types import Interval

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.ranges import HalfLength, Metre
from deformpush.cell.robot import Robot
from deformpush.worlds.bullet.drive import drive
from deformpush.worlds.bullet.engine import Engine, SoftBody, connect
from deformpush.worlds.finite_elements import TABLE_THICKNESS, FiniteElementWorld
from deformpush.worlds.fork import pictures_after
from deformpush.worlds.tool_motion import Motion

Array = np.ndarray


@dataclass(frozen=True)
class Bullet:
    """`world=bullet`: finite elements on a frictional table."""

    engine: Engine
    margin: Annotated[float, Interval(ge=5e-4, le=5e-3)]
    """Collision margin of the soft body (m): it floats this high and is touched this far outside."""
    motion: Motion
    table: tuple[Metre, Metre, HalfLength, HalfLength]
    """Middle x, y and half lengths x, y of the table (m)."""

    def build(self, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float) -> "BulletWorld":
        """Put table, object and tool into a fresh world."""
        return BulletWorld(self, sheet, robot, camera, tool_radius)


class BulletWorld(FiniteElementWorld):
    """One object on one table, in one client of PyBullet."""

    offers = frozenset({"strain", "film", "branches"})

    def __init__(
        self, spec: Bullet, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float
    ) -> None:
        mesh = sheet.slab.mesh
        self.client = connect(spec.engine)
        table = _add_table(self.client, spec)
        body = SoftBody(self.client, spec.engine, spec.margin, mesh, sheet)
        tool = drive(robot, self.client, tool_radius)
        # The tip glides just above the glass; without this the margins of table and tool would touch.
        self.client.setCollisionFilterPair(table, tool.id, -1, tool.link, 0)
        super().__init__(spec, sheet, camera, tool_radius, mesh, body, tool)

    def picture(self) -> Array:
        """Picture from below, mirrored so that it reads like a map of the table seen from above."""
        c, (x, y) = self.camera, self.camera.centre
        view = self.client.computeViewMatrix([x, y, -c.distance], [x, y, 0], [0, 1, 0])
        angle = np.degrees(2 * np.arctan2(c.field / 2, c.distance))
        lens = list(self.client.computeProjectionMatrixFOV(angle, 1.0, 0.1, c.distance + 3))
        # The renderer puts the optical axis half a pixel off the picture's middle, both ways: move it back.
        lens[8] = lens[9] = 1 / c.pixels
        shot = self.client.getCameraImage(
            c.pixels,
            c.pixels,
            view,
            lens,
            lightDirection=[0.3, -0.2, -1],
            shadow=0,
            renderer=self.client.ER_TINY_RENDERER,
            flags=self.client.ER_NO_SEGMENTATION_MASK,
        )
        rgba = np.asarray(shot[2], np.uint8).reshape(c.pixels, c.pixels, 4)
        return c.through_lens(np.ascontiguousarray(rgba[:, ::-1, :3]))

    def pictures_after(self, paths: Sequence[ToolPath]) -> list[Array | None]:
        """The picture after each of these pushes, each made in a copy of the whole process."""
        return pictures_after(self, paths)

    def close(self) -> None:
        """Free the engine and what the tool holds."""
        super().close()
        self.client.disconnect()


def _add_table(client: Any, spec: Bullet) -> int:
    """A box, because Bullet's infinite plane is a poor table for soft bodies."""
    x, y, hx, hy = spec.table
    shape = client.createCollisionShape(client.GEOM_BOX, halfExtents=[hx, hy, TABLE_THICKNESS / 2])
    table = client.createMultiBody(0, shape, -1, [x, y, -TABLE_THICKNESS / 2])
    client.changeDynamics(table, -1, lateralFriction=1.0)
    client.changeVisualShape(table, -1, rgbaColor=[0, 0, 0, 0])  # glass
    return int(table)
