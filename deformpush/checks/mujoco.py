"""The gates of `world=mujoco`: what every engine is held to, weight, warnings, states, camera and arm."""

from collections.abc import Iterator

import mujoco
import numpy as np

from deformpush.cell.object import SoftObject
from deformpush.cell.world import WorldError
from deformpush.checks import accuracy
from deformpush.checks.bench import Bench, Limits, LoneBody
from deformpush.checks.gate import Gate
from deformpush.checks.physics import SHARED, examine
from deformpush.config.compose import compose
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.setup import read
from deformpush.worlds.mujoco.drive import AWAY
from deformpush.worlds.mujoco.model import ToolShape, build_model, rest_nodes
from deformpush.worlds.mujoco.simulation import MujocoSimulation
from deformpush.worlds.mujoco.world import MujocoWorld
from deformpush.worlds.tool_motion import Line, ramp

Array = np.ndarray


class MujocoBench(Bench):
    """MuJoCo with the bare tool."""

    limits = Limits(
        stiffness=0.01, pose_dt=(5e-4, 5e-4), pose_mesh=(2e-3, 2e-3), strain_dt=0.02, strain_mesh=0.1
    )

    def gates(self) -> Iterator[Gate]:
        """What every engine is held to, then what this one is, then camera and arm."""
        yield from examine(self, (*SHARED, weight, chain, explosion, states))
        yield from accuracy.gates(self.overrides)

    def on_table(self, sheet: SoftObject) -> LoneBody:
        """An object on the table, which has no end."""
        return _Lone(self, sheet, held=False)

    def hung(self, sheet: SoftObject, pull: float) -> LoneBody:
        """An object whose left end does not move; contacts are off."""
        body = _Lone(self, sheet, held=True)
        body.model.opt.gravity[:] = (pull, 0, 0)
        body.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        return body


class _Lone:
    """See `LoneBody`."""

    def __init__(self, bench: Bench, sheet: SoftObject, held: bool) -> None:
        engine, margin = bench.spec.engine, bench.spec.margin
        mesh = sheet.slab.mesh
        x = mesh.nodes[:, 0]
        fixed = np.flatnonzero(np.isclose(x, x.min())).tolist() if held else ()
        far = ToolShape(bench.tool_radius, bench.tool.length, 0.0)
        self.model = build_model(mesh, sheet, engine, margin, far, fixed)
        rest = rest_nodes(mesh, sheet, margin)
        self.simulation = MujocoSimulation(self.model, rest, engine.check_every)
        self.simulation.move_tool(AWAY, np.zeros(2))
        self.masses = np.array(self.model.body_mass[self.model.flex_vertbodyid])

    def nodes(self) -> Array:
        return self.simulation.nodes()

    def launch(self, speed: float) -> None:
        self.simulation.data.qvel[:-2:3] = speed

    def step(self, seconds: float) -> None:
        for _ in range(round(seconds / self.simulation.dt)):
            self.simulation.step()

    def close(self) -> None:
        """Nothing to free."""


def weight(bench: Bench) -> Gate:
    """At rest the table carries the object's weight."""
    body = bench.on_table(bench.sheet)
    assert isinstance(body, _Lone)
    body.step(1.0)
    data, force = body.simulation.data, np.zeros(6)
    carried = 0.0
    for contact in range(data.ncon):
        mujoco.mj_contactForce(body.model, data, contact, force)
        carried += force[0]
    expected = float(body.masses.sum()) * bench.spec.engine.gravity
    return Gate(
        "weight on the table",
        f"{carried:.4f} N of {expected:.4f} N",
        "within 0.1 %",
        abs(carried / expected - 1) <= 1e-3,
    )


def chain(bench: Bench, pushes: int = 10) -> Gate:
    """Random pushes one after the other, without a warning of the engine and without an explosion."""
    setup = read(compose(["robot=tool", *bench.overrides]))
    cell, rng = build_cell(setup), np.random.default_rng(0)
    seen, said = None, "no warning"
    for _ in range(pushes):
        seen = cell.look(seen)[0].seen
        _, path = cell.reachable(np.array([rng.uniform(), rng.uniform(*setup.object.d)]), seen)
        try:
            cell.world.push(path)
        except WorldError as problem:
            said = str(problem)
            break
    cell.world.close()
    return Gate(f"{pushes} random pushes in a chain", said, "no warning, no explosion", said == "no warning")


def explosion(bench: Bench) -> Gate:
    """A node that flies off is noticed."""
    world = bench.world()
    assert isinstance(world, MujocoWorld)
    world.simulation.data.qvel[0] = 1e3
    try:
        world.push(bench.path(0.03))
        noticed = "nothing"
    except WorldError as problem:
        noticed = str(problem).split(":")[0]
    world.close()
    return Gate("a node that flies off", noticed, "it is noticed", noticed != "nothing")


def states(bench: Bench) -> Gate:
    """A state saved while the tool presses leads to the same bits in a world built anew."""
    ends: list[Array] = []
    state = b""
    for world in (bench.world(), bench.world()):
        assert isinstance(world, MujocoWorld)
        line = Line(bench.path(bench.sheet.d[1]), bench.spec.motion.lead)
        profile = ramp(line.length, 0.15, 1.5, world.simulation.dt)
        half = len(profile) // 2
        if not state:
            carry(world, line, profile[:half])
            pressed, state = world.simulation.tool_force() > 0, world.save()
        world.restore(state)
        carry(world, line, profile[half:])
        ends.append(world.nodes())
        world.close()
    same = bool(np.array_equal(ends[0], ends[1]))
    told = "identical bits" if same else "different"
    return Gate("state saved in contact, taken up", told, "identical bits", same and pressed)


def carry(world: MujocoWorld, line: Line, profile: Array) -> None:
    """Move the tool along a line, distance and speed `(n, 2)` at the end of each step."""
    for s, v in profile:
        world.tool.follow(line.at(s - v * world.simulation.dt), v * line.direction)
        world.simulation.step()
