"""The PyBullet world: soft slab, table, tool, camera below, and how one push is executed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Gt, Interval

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.robot import Robot
from deformpush.cell.world import Moment, Outcome, Scenery, Strain, World, WorldError
from deformpush.mechanics.strain import Gauge, RestShape
from deformpush.worlds.bullet.drive import drive
from deformpush.worlds.bullet.engine import Engine, SoftBody, connect
from deformpush.worlds.fork import pictures_after

Array = np.ndarray

_SAMPLE_S = 0.01  # s; the strain during a push is measured this often, as near as whole steps come
_TABLE_THICKNESS = 0.05  # m; a box, because Bullet's infinite plane is a poor table for soft bodies


@dataclass(frozen=True)
class Motion:
    """How a push is executed."""

    speed: Annotated[float, Gt(0)]
    """Tool speed (m/s)."""
    acceleration: Annotated[float, Gt(0)]
    """Tool acceleration and deceleration (m/s^2)."""
    lead: Annotated[float, Gt(0)]
    """The tool is put down this far before the touch, clear of the object (m)."""
    clear: Annotated[float, Gt(0)]
    """On its way back the tool is lifted once the object is this far away from it (m)."""
    settle_speed: Annotated[float, Gt(0)]
    """The object is at rest when no node moves faster (m/s)."""
    settle_s: Annotated[float, Ge(0)]
    """But no longer than this (s)."""
    frames: Annotated[int, Interval(ge=0, le=100)]
    """Instants of each push that are kept for the recording."""


@dataclass(frozen=True)
class Bullet:
    """`world=bullet`: finite elements on a frictional table."""

    engine: Engine
    margin: Annotated[float, Interval(ge=5e-4, le=5e-3)]
    """Collision margin of the soft body (m): it floats this high and is touched this far outside."""
    motion: Motion
    table: tuple[float, float, float, float]
    """Middle x, y and half lengths x, y of the table (m)."""

    def build(self, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float) -> "BulletWorld":
        """Put table, object and tool into a fresh world."""
        return BulletWorld(self, sheet, robot, camera, tool_radius)


class BulletWorld(World):
    """One object on one table, in one engine."""

    offers = frozenset({"strain", "film", "branches"})

    check_every = 8
    """Steps between looks at the mesh: explosion guard, rest, clearance."""

    def __init__(
        self, spec: Bullet, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float
    ) -> None:
        self.spec, self.camera, self.tool_radius, self.margin = spec, camera, tool_radius, spec.margin
        self.mesh = sheet.slab.mesh
        self.rest, self.strain_limit = RestShape(self.mesh), sheet.strain_limit
        self._gauge = Gauge(self.rest)
        self._sample_every = max(1, round(_SAMPLE_S / spec.engine.dt))
        self.client = connect(spec.engine)
        table = self._add_table()
        self.body = SoftBody(self.client, spec.engine, spec.margin, self.mesh, sheet)
        self.tool = drive(robot, self.client, tool_radius)
        # The tip glides just above the glass; without this the margins of table and tool would touch.
        self.client.setCollisionFilterPair(table, self.tool.id, -1, self.tool.link, 0)
        self._settle(Outcome(), at_least=0.1)

    def push(self, path: ToolPath) -> Outcome:
        """Push along the path and come back; see `World.push`."""
        motion, outcome = self.spec.motion, Outcome()
        self._gauge = Gauge(self.rest)
        way = _Line(path, min(path.approach, motion.lead))
        back = way.length + 4 * motion.clear  # room to come clear, should the object follow
        points = np.linspace(-4 * motion.clear, way.length, max(3, int((back) / 0.003)))
        self.tool.prepare(way.at(points))
        self.tool.place(way.at(0.0))
        forth = _ramp(way.length, path.speed or motion.speed, motion.acceleration, self.spec.engine.dt)
        home = _ramp(back, motion.speed, motion.acceleration, self.spec.engine.dt)
        keep = np.unique(np.linspace(0, len(forth), motion.frames + 1, dtype=int)[1:])
        samples = self._travel(way, forth[:, 0], forth[:, 1], outcome, keep)
        between = 1 / (self.camera.rate * self._sample_every * self.spec.engine.dt)
        outcome.film = samples[:: max(1, round(between))]
        self._travel(way, way.length - home[:, 0], -home[:, 1], outcome, until_clear=True)
        self.tool.park()
        self._settle(outcome)
        self._measure(outcome)
        return outcome

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
        return np.ascontiguousarray(rgba[:, ::-1, :3])

    def nodes(self) -> Array:
        """Mesh nodes `(N, 3)` (m)."""
        return self.body.nodes()

    def strain(self) -> Array:
        """Largest strain at each mesh node `(N,)` (-)."""
        return self.rest.at_nodes(self.rest.strain(self.nodes()))

    def joints(self) -> dict[str, float]:
        """Arm joint angles (rad)."""
        return self.tool.joints()

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` the tool can take."""
        return self.tool.can_reach(points)

    def scenery(self) -> Scenery:
        """What a recorder may draw."""
        x, y, hx, hy = self.spec.table
        return Scenery(
            table_centre=(x, y, -_TABLE_THICKNESS / 2),
            table_half_size=(hx, hy, _TABLE_THICKNESS / 2),
            mesh_triangles=self.mesh.surface(),
            arm_urdf=self.tool.urdf,
        )

    def pictures_after(self, paths: Sequence[ToolPath]) -> list[Array | None]:
        """The picture after each of these pushes, each made in a copy of the whole process."""
        return pictures_after(self, paths)

    def close(self) -> None:
        """Free the engine and what the tool holds."""
        self.tool.close()
        self.client.disconnect()

    def _add_table(self) -> int:
        x, y, hx, hy = self.spec.table
        shape = self.client.createCollisionShape(
            self.client.GEOM_BOX, halfExtents=[hx, hy, _TABLE_THICKNESS / 2]
        )
        table = self.client.createMultiBody(0, shape, -1, [x, y, -_TABLE_THICKNESS / 2])
        self.client.changeDynamics(table, -1, lateralFriction=1.0)
        self.client.changeVisualShape(table, -1, rgbaColor=[0, 0, 0, 0])  # glass
        return int(table)

    def _travel(
        self,
        way: "_Line",
        at: Array,
        speed: Array,
        outcome: Outcome,
        keep: Array | tuple[()] = (),
        until_clear: bool = False,
    ) -> list[Array]:
        """Carry the tool along `way` at the given distances and speeds, one physics step each.

        Returns:
            The nodes `(N, 3)` at each look at the strain.
        """
        dt = self.spec.engine.dt
        samples: list[Array] = []
        for n, (s, v) in enumerate(zip(at, speed, strict=True), start=1):
            # The drive is given where the step begins and how fast it goes: it ends where the profile says.
            self.tool.follow(way.at(s - v * dt), v * way.direction)
            samples += self._step(outcome)
            if n % self.check_every == 0 or n in keep:
                nodes, tip = self.nodes(), self.tool.tip()
                self.body.check(nodes)
                if not until_clear:
                    outcome.tip_error = max(outcome.tip_error, float(np.linalg.norm(tip[:2] - way.at(s))))
                if n in keep:
                    outcome.motion.append(Moment(outcome.sim_s, tip, nodes, self.joints()))
                if until_clear and s < way.length / 2 and self._gap(nodes, tip[:2]) > self.spec.motion.clear:
                    return samples
        if until_clear and self._gap(self.nodes(), self.tool.tip()[:2]) < 0:
            raise WorldError("the object sticks to the tool: the tool could not come clear on its way back")
        return samples

    def _step(self, outcome: Outcome) -> list[Array]:
        """One physics step, and every so often a look at the strain: the nodes it was taken of, if it was."""
        with outcome.stepping(1, self.spec.engine.dt):
            self.client.stepSimulation()
        if outcome.steps % self._sample_every:
            return []
        nodes = self.nodes()
        self._gauge.look(nodes)
        return [nodes]

    def _measure(self, outcome: Outcome) -> None:
        """Add the strain of the push that has just ended, and that of its moments."""
        peak = self._gauge.peak()
        looks = [moment.nodes for moment in outcome.motion if moment.nodes is not None]
        *moments, now = self.rest.strain(np.stack([*looks, self.nodes()]))
        residual = self.rest.aggregates(now).p99
        field = self.rest.at_nodes(self._gauge.field())
        outcome.strain = Strain(peak.p99, peak.top10, peak.maximum, residual, self.strain_limit, field)
        outcome.motion = [
            replace(moment, strain=self.rest.at_nodes(strain))
            for moment, strain in zip(outcome.motion, moments, strict=True)
        ]

    def _gap(self, nodes: Array, tip: Array) -> float:
        return float(np.linalg.norm(nodes[:, :2] - tip, axis=1).min()) - self.tool_radius

    def _settle(self, outcome: Outcome, at_least: float = 0.0) -> None:
        """Step until no node moves faster than the settling speed."""
        dt, motion = self.spec.engine.dt, self.spec.motion
        waited, before = 0.0, self.nodes()
        while waited < max(motion.settle_s, at_least):
            for _ in range(self.check_every):
                self._step(outcome)
            waited += self.check_every * dt
            nodes = self.nodes()
            self.body.check(nodes)
            fastest = np.linalg.norm(nodes - before, axis=1).max() / (self.check_every * dt)
            if fastest < motion.settle_speed and waited >= at_least:
                return
            before = nodes


class _Line:
    """The part of a tool path that is executed in contact or near it."""

    def __init__(self, path: ToolPath, lead: float) -> None:
        self.origin = path.contact - lead * path.direction
        self.direction = path.direction
        self.length = lead + path.d

    def at(self, s: Any) -> Array:
        """Tool centre after travelling s (m): `(2,)` or `(P, 2)`."""
        return self.origin + np.multiply.outer(s, self.direction)


def _ramp(length: float, speed: float, acceleration: float, dt: float) -> Array:
    """Distance and speed `(n, 2)` at the end of each step of a trapezoidal profile from rest to rest."""
    top = min(speed, np.sqrt(length * acceleration))
    rise = top / acceleration
    duration = length / top + rise
    t = np.arange(1, int(np.ceil(duration / dt)) + 1) * dt
    left = np.maximum(duration - t, 0.0)
    s = np.where(
        t < rise,
        acceleration * t**2 / 2,
        np.where(left < rise, length - acceleration * left**2 / 2, top * (t - rise / 2)),
    )
    return np.column_stack([s, np.diff(s, prepend=0.0) / dt])
