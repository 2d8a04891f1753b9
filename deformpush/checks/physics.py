"""Physics gates that every finite element engine is held to before any number of this project counts."""

import hashlib
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from deformpush.cell.object import SoftObject
from deformpush.cell.world import WorldError
from deformpush.checks.bench import Bench
from deformpush.checks.gate import Gate
from deformpush.mechanics.geometry import matched_turn, resample, signed_area
from deformpush.mechanics.mesh import TetMesh

Array = np.ndarray

Examine = Callable[[Bench], Gate]

ASIDE = (0.0, 0.15, -0.3)
"""Where the strain of a push is measured, as shares of the object's half length."""
PLACES = (0.0, 0.2)
"""Where the pose after a push is compared: in the middle and off it, as shares of the half length."""


def examine(bench: Bench, gates: Sequence[Examine]) -> Iterator[Gate]:
    """Run one gate after the other; one whose simulation cannot be trusted has failed."""
    for gate in gates:
        try:
            yield gate(bench)
        except WorldError as problem:
            yield Gate(gate.__name__.replace("_", " "), f"none: {problem}", "a simulation to trust", False)


def friction(bench: Bench, speed: float = 2.0) -> Gate:
    """A sliding slab stops after v^2 / (2 mu g).

    The engine lets friction act before it moves a node: the distance is short by v dt / 2, whatever the
    speed. A fast slide keeps that small beside the distance.
    """
    gravity, mu = bench.spec.engine.gravity, bench.sheet.material.friction
    body = bench.on_table(bench.sheet)
    body.step(0.2)
    body.launch(speed)
    before = body.nodes()[:, 0].mean()
    body.step(2 * speed / (mu * gravity))
    measured = body.nodes()[:, 0].mean() - before
    body.close()
    expected = speed**2 / (2 * mu * gravity)
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
        f"within {_percent(bench.limits.stiffness)} of the configured",
        abs(measured / wanted - 1) <= bench.limits.stiffness,
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
    found, halved = plans(bench), plans(bench, dt=bench.spec.engine.dt / 2)
    return _same_pose("pose after a push, dt halved", found, halved, bench.limits.pose_dt)


def mesh_size(bench: Bench) -> Gate:
    """A finer mesh, whose smaller cells need half the time step, leads to the same pose."""
    refined = plans(finer(bench), dt=bench.spec.engine.dt / 2)
    return _same_pose("pose after a push, mesh refined", plans(bench), refined, bench.limits.pose_mesh)


def strain_time_step(bench: Bench) -> Gate:
    """Half the time step leads to the same peak strain."""
    return _same_strain("strain of a push, dt halved", bench, bench, bench.limits.strain_dt)


def strain_mesh_size(bench: Bench) -> Gate:
    """A finer mesh, whose smaller cells need half the time step, leads to the same peak strain."""
    return _same_strain("strain of a push, mesh refined", bench, finer(bench), bench.limits.strain_mesh)


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


def measured_modulus(bench: Bench, sheet: SoftObject) -> float:
    """Young's modulus (Pa) from the stretch of a slab hung by its left end in a gentle sideways gravity.

    The force through a section is the weight of what hangs below it; section by section,
    E = force / (area strain). Sections near the held end and the free end are left out.
    """
    rect = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (0.2, 0.1)
    sheet = replace(sheet, outline=tuple(map(tuple, rect)), thickness=0.02, cell=0.02, mesh="grid")
    sheet = replace(sheet, start=(0.0, 0.0), start_deg=0.0)
    mass = sheet.material.total_mass(0.2 * 0.1 * 0.02)
    pull = 0.02 * sheet.material.youngs_modulus * (0.1 * 0.02) / mass  # the largest strain is 2 %
    body = bench.hung(sheet, pull)
    rest = body.nodes()
    body.step(3.0)
    moved = body.nodes()[:, 0] - rest[:, 0]
    body.close()
    columns, member = np.unique(np.round(rest[:, 0], 6), return_inverse=True)
    count = np.bincount(member)
    stretch = np.diff(np.bincount(member, moved) / count) / np.diff(columns)
    hanging = mass - np.cumsum(np.bincount(member, body.masses))[:-1]
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


def finer(bench: Bench) -> Bench:
    """The same bench with a finer mesh."""
    return replace(bench, sheet=replace(bench.sheet, cell=bench.sheet.cell / 1.5))


def plans(bench: Bench, **engine: float) -> list[Array]:
    """The plan `(V, 2)` (m) after one long push at each of `PLACES`, each in a fresh world."""
    half, found = float(np.ptp(bench.sheet.polygon[:, 0])) / 2, []
    for share in PLACES:
        world = bench.world(**engine)
        world.push(bench.path(bench.sheet.d[1], share * half))
        found.append(rim(world.mesh, world.nodes()))
        world.close()
    return found


def peak_strains(bench: Bench, **engine: float) -> Array:
    """Peak p99 strain of a long push at each of `ASIDE`, each in a fresh world."""
    half, found = float(np.ptp(bench.sheet.polygon[:, 0])) / 2, []
    for share in ASIDE:
        world = bench.world(**engine)
        strain = world.push(bench.path(bench.sheet.d[1], share * half)).strain
        world.close()
        assert strain is not None, "these worlds measure it"
        found.append(strain.p99_peak)
    return np.array(found)


def _same_pose(name: str, was: Sequence[Array], now: Sequence[Array], allowed: Sequence[float]) -> Gate:
    """Compare centroids, place by place; how far one is turned against the other is told as well."""
    moved = [float(np.linalg.norm(centroid(a) - centroid(b))) for a, b in zip(was, now, strict=True)]
    turned = [
        matched_turn(*(resample(plan, 256) - centroid(plan) for plan in pair))
        for pair in zip(was, now, strict=True)
    ]
    told = [f"{m * 1e3:.2f} mm {abs(np.degrees(t)):.1f} deg" for m, t in zip(moved, turned, strict=True)]
    return Gate(
        name,
        "; ".join(told),
        f"under {' and '.join(f'{limit * 1e3:g}' for limit in dict.fromkeys(allowed))} mm",
        all(m < limit for m, limit in zip(moved, allowed, strict=True)),
    )


def _same_strain(name: str, bench: Bench, changed: Bench, allowed: float) -> Gate:
    """Compare the mean over `ASIDE` with that of a changed bench at half the time step.

    A coarse mesh is struck now at a node, now between two, and answers now too softly, now too stiffly: the
    mean over several places is what a finer mesh can be held against. The largest change of one place is
    told as well.
    """
    was, limit = peak_strains(bench), f"p99 within {_percent(allowed)}"
    try:
        now = peak_strains(changed, dt=bench.spec.engine.dt / 2)
    except WorldError as problem:
        return Gate(name, f"none: {str(problem).split(':')[0]}", limit, False)
    moved, worst = now.mean() / was.mean() - 1, max(now / was - 1, key=abs)
    return Gate(name, f"p99 {moved:+.1%} (one place {worst:+.0%})", limit, bool(abs(moved) < allowed))


def _percent(share: float) -> str:
    return f"{100 * share:g} %"


def centroid(polygon: Array) -> Array:
    """Centroid of the area of a polygon `(V, 2)`."""
    x, y = polygon.T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    return np.array([(v + np.roll(v, -1)) @ cross for v in (x, y)]) / (3 * cross.sum())


SHARED: tuple[Examine, ...] = (
    friction,
    stiffness,
    material_of_second_scene,
    time_step,
    mesh_size,
    strain_time_step,
    strain_mesh_size,
    area_at_rest,
    repeatable,
)
"""For every engine."""
