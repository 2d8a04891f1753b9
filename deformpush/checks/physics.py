"""Physics gates: what has to hold before any number of this project counts."""

import hashlib
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.robot import BareTool
from deformpush.cell.world import WorldError
from deformpush.checks.gate import Gate
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.setup import read
from deformpush.mechanics.geometry import signed_area
from deformpush.mechanics.mesh import TetMesh
from deformpush.worlds.bullet.engine import Engine, SoftBody, connect
from deformpush.worlds.bullet.world import Bullet, BulletWorld

Array = np.ndarray

ASIDE = (0.0, 0.15, -0.3)
"""Where the strain of a push is measured, as shares of the object's half length."""


@dataclass(frozen=True)
class Bench:
    """The configured parts that the gates examine."""

    spec: Bullet
    sheet: SoftObject
    tool: BareTool
    camera: Camera
    tool_radius: float
    overrides: tuple[str, ...] = ()
    """Command line settings that lead to the same parts, for a second process."""

    def world(self, **engine: float) -> BulletWorld:
        """A world with the bare tool, some engine numbers changed."""
        spec = replace(self.spec, engine=replace(self.spec.engine, **engine))
        return spec.build(self.sheet, self.tool, self.camera, self.tool_radius)

    def path(self, d: float, aside: float = 0.0) -> ToolPath:
        """A push by `d` (m) in y against the object's lower side, `aside` (m) right of its middle."""
        x, y = self.sheet.start
        x += aside
        low = y + self.sheet.polygon[:, 1].min() - self.tool_radius - self.spec.margin
        return ToolPath(np.array([x, low - 0.01]), np.array([0.0, 1.0]), 0.01, d)


def build_bench(overrides: Sequence[str]) -> Bench:
    """Build what the gates examine.

    Raises:
        UserError: names the setting that is wrong, or says that the gates need `world=bullet`.
    """
    setup = read(compose(["robot=tool", *overrides]))
    spec, robot = setup.world, setup.robot
    if not isinstance(spec, Bullet) or not isinstance(robot, BareTool):
        raise UserError(
            f"world={setup.options['world']}, robot={setup.options['robot']}: the physics gates need "
            "world=bullet with robot=tool"
        )
    return Bench(spec, setup.object, robot, setup.camera, setup.push.tool_radius, tuple(overrides))


def all_gates(bench: Bench) -> Iterator[Gate]:
    """Run one gate after the other."""
    gates: tuple[Callable[[Bench], Gate], ...] = (
        friction,
        stiffness,
        material_of_second_scene,
        time_step,
        mesh_size,
        strain_time_step,
        strain_mesh_size,
        area_at_rest,
        repeatable,
        explosion,
    )
    for gate in gates:
        yield gate(bench)


def friction(bench: Bench, speed: float = 2.0) -> Gate:
    """A sliding slab stops after v^2 / (2 mu g).

    The engine lets friction act before it moves a node: the distance is short by v dt / 2, whatever the
    speed. A fast slide keeps that small beside the distance.
    """
    engine, mu = bench.spec.engine, bench.sheet.material.friction
    client, body = _lone_body(bench, bench.sheet)
    shape = client.createCollisionShape(client.GEOM_BOX, halfExtents=[4, 4, 0.025])
    client.changeDynamics(client.createMultiBody(0, shape, -1, [0, 0, -0.025]), -1, lateralFriction=1.0)
    _steps(client, engine, 0.2)
    client.resetBaseVelocity(body.id, [speed, 0, 0])
    before = body.nodes()[:, 0].mean()
    _steps(client, engine, 2 * speed / (mu * engine.gravity))
    measured = body.nodes()[:, 0].mean() - before
    client.disconnect()
    expected = speed**2 / (2 * mu * engine.gravity)
    return Gate(
        "friction: stop distance",
        f"{measured * 1e3:.1f} mm of {expected * 1e3:.1f} mm ({measured / expected - 1:+.1%})",
        "within 2 % of v^2 / 2 mu g",
        abs(measured / expected - 1) <= 0.02,
    )


def stiffness(bench: Bench) -> Gate:
    """A slab hung by one end stretches as its Young's modulus says."""
    wanted, measured = bench.sheet.material.youngs_modulus, measured_modulus(bench, bench.sheet)
    return Gate(
        "stiffness: Young's modulus",
        f"{measured / 1e3:.2f} kPa of {wanted / 1e3:.2f} kPa ({measured / wanted - 1:+.1%})",
        "within 5 % of the configured",
        abs(measured / wanted - 1) <= 0.05,
    )


def material_of_second_scene(bench: Bench) -> Gate:
    """A second scene in the same process has its own material, not the first one's."""
    stiffer = replace(bench.sheet, material=bench.sheet.material.scaled(4.0, 1.0, 1.0))
    ratio = measured_modulus(bench, stiffer) / measured_modulus(bench, bench.sheet)
    return Gate(
        "material of a second scene",
        f"{ratio:.2f} times as stiff",
        "4 times, within 5 %",
        abs(ratio / 4 - 1) <= 0.05,
    )


def time_step(bench: Bench) -> Gate:
    """Half the time step leads to the same pose."""
    moved = np.linalg.norm(_pushed(bench) - _pushed(bench, dt=bench.spec.engine.dt / 2))
    return Gate("pose after a push, dt halved", f"{moved * 1e3:.2f} mm", "under 2 mm", bool(moved < 2e-3))


def mesh_size(bench: Bench) -> Gate:
    """A finer mesh leads to the same pose."""
    finer = replace(bench, sheet=replace(bench.sheet, cell=bench.sheet.cell / 1.5))
    moved = np.linalg.norm(_pushed(bench) - _pushed(finer))
    return Gate("pose after a push, mesh refined", f"{moved * 1e3:.2f} mm", "under 2 mm", bool(moved < 2e-3))


def strain_time_step(bench: Bench) -> Gate:
    """Half the time step leads to the same peak strain."""
    return _same_strain("strain of a push, dt halved", bench, bench)


def strain_mesh_size(bench: Bench) -> Gate:
    """A finer mesh, whose smaller cells need half the time step, leads to the same peak strain."""
    finer = replace(bench, sheet=replace(bench.sheet, cell=bench.sheet.cell / 1.5))
    return _same_strain("strain of a push, mesh refined", bench, finer)


def area_at_rest(bench: Bench) -> Gate:
    """Nodes of the settled mesh lie where the configuration put the object, and keep its area."""
    world = bench.world()
    seen = rim(world.mesh, world.nodes())
    world.close()
    area = signed_area(seen) / signed_area(bench.sheet.polygon) - 1
    return Gate("object at rest: area kept", f"{area:+.2%}", "within 1 %", abs(area) <= 0.01)


def repeatable(bench: Bench) -> Gate:
    """Two processes that push alike end with the same bits."""
    command = [sys.executable, "-m", "deformpush", "doctor", "--digest", *bench.overrides]
    runs = [subprocess.run(command, capture_output=True, text=True, check=True) for _ in range(2)]
    digests = [run.stdout.strip() for run in runs]
    same = digests[0] == digests[1] and len(digests[0]) == 64
    return Gate(
        "same push in two processes", "identical bits" if same else "different", "identical bits", same
    )


def digest(bench: Bench) -> str:
    """Hash of all nodes after two pushes."""
    world = bench.world()
    for d in (0.02, 0.03):
        world.push(bench.path(d))
    nodes = world.nodes()
    world.close()
    return hashlib.sha256(np.ascontiguousarray(nodes).tobytes()).hexdigest()


def explosion(bench: Bench) -> Gate:
    """A time step beyond stability is noticed, though the engine reports nothing."""
    world = bench.world()
    world.client.setTimeStep(5 * bench.spec.engine.damping)  # stable up to twice the damping
    try:
        world.push(bench.path(0.03))
        noticed = "nothing"
    except WorldError as problem:
        noticed = str(problem).split(":")[0]
    world.close()
    return Gate("provoked explosion", f"guard said: {noticed}", "the guard trips", "exploded" in noticed)


def measured_modulus(bench: Bench, sheet: SoftObject) -> float:
    """Young's modulus (Pa) from the stretch of a slab hung by its left end in a gentle sideways gravity.

    The force through a section is the weight of what hangs below it; section by section,
    E = force / (area strain). Sections near the held end and the free end are left out.
    """
    rect = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (0.2, 0.1)
    sheet = replace(sheet, outline=tuple(map(tuple, rect)), thickness=0.02, cell=0.02, mesh="grid")
    sheet = replace(sheet, start=(0.0, 0.0), start_deg=0.0)
    client, body = _lone_body(bench, sheet)
    rest = body.nodes()
    mass = sheet.material.total_mass(float(body.mesh.volumes.sum()))
    modulus = sheet.material.youngs_modulus
    pull = 0.02 * modulus * (0.1 * 0.02) / mass  # the largest strain is 2 %
    client.setGravity(pull, 0, 0)
    for node in np.flatnonzero(np.isclose(rest[:, 0], rest[:, 0].min())):
        client.createSoftBodyAnchor(body.id, int(node), -1, -1)
    _steps(client, bench.spec.engine, 3.0)
    moved = body.nodes()[:, 0] - rest[:, 0]
    client.disconnect()
    columns, member = np.unique(np.round(rest[:, 0], 6), return_inverse=True)
    count = np.bincount(member)
    stretch = np.diff(np.bincount(member, moved) / count) / np.diff(columns)
    hanging = mass / len(rest) * (len(rest) - np.cumsum(count)[:-1])
    modulus_of_section = hanging * pull / (0.1 * 0.02) / stretch
    return float(np.mean(modulus_of_section[2:-3]))


def rim(mesh: TetMesh, nodes: Array) -> Array:
    """Corners `(V, 2)` of the underside's boundary, counter-clockwise: the plan as the mesh has it."""
    faces = mesh.surface()
    under = faces[np.all(mesh.nodes[faces][:, :, 2] < 1e-9, axis=1)]
    edges = np.concatenate([under[:, [1, 0]], under[:, [2, 1]], under[:, [0, 2]]])  # seen from above
    follower = {(a, b) for a, b in edges.tolist()}
    boundary = {a: b for a, b in follower if (b, a) not in follower}
    loop = [next(iter(boundary))]
    while boundary[loop[-1]] != loop[0]:
        loop.append(boundary[loop[-1]])
    return np.asarray(nodes[loop, :2])


def peak_strains(bench: Bench, **engine: float) -> Array:
    """Peak p99 strain of a long push at each of `ASIDE`, each in a fresh world."""
    half, found = float(np.ptp(bench.sheet.polygon[:, 0])) / 2, []
    for share in ASIDE:
        world = bench.world(**engine)
        strain = world.push(bench.path(bench.sheet.d[1], share * half)).strain
        world.close()
        assert strain is not None, "Bullet measures it"
        found.append(strain.p99_peak)
    return np.array(found)


def _same_strain(name: str, bench: Bench, changed: Bench) -> Gate:
    """Compare the mean over `ASIDE` with that of a changed bench at half the time step.

    A coarse mesh is struck now at a node, now between two, and answers now too softly, now too stiffly: the
    mean over several places is what a finer mesh can be held against. The largest change of one place is
    told as well.
    """
    was = peak_strains(bench)
    try:
        now = peak_strains(changed, dt=bench.spec.engine.dt / 2)
    except WorldError as problem:
        return Gate(name, f"none: {str(problem).split(':')[0]}", "p99 within 10 %", False)
    moved, worst = now.mean() / was.mean() - 1, max(now / was - 1, key=abs)
    return Gate(name, f"p99 {moved:+.1%} (one place {worst:+.0%})", "p99 within 10 %", abs(moved) < 0.1)


def _pushed(bench: Bench, **engine: float) -> Array:
    """Centroid of the plan after one long push."""
    world = bench.world(**engine)
    world.push(bench.path(bench.sheet.d[1]))
    plan = rim(world.mesh, world.nodes())
    world.close()
    return centroid(plan)


def centroid(polygon: Array) -> Array:
    """Centroid of the area of a polygon `(V, 2)`."""
    x, y = polygon.T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    return np.array([(v + np.roll(v, -1)) @ cross for v in (x, y)]) / (3 * cross.sum())


def _lone_body(bench: Bench, sheet: SoftObject) -> tuple[Any, SoftBody]:
    client = connect(bench.spec.engine)
    return client, SoftBody(client, bench.spec.engine, bench.spec.margin, sheet.slab.mesh, sheet)


def _steps(client: Any, engine: Engine, seconds: float) -> None:
    for _ in range(round(seconds / engine.dt)):
        client.stepSimulation()
