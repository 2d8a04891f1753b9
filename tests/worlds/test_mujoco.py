"""The MuJoCo world: closed forms of its law and masses, what it refuses, force, silence."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from deformpush.cell.world import WorldError
from deformpush.checks import mujoco as gates
from deformpush.checks.by_world import build_bench
from deformpush.checks.contract import contract
from deformpush.checks.physics import centroid, friction, rim, stiffness
from deformpush.errors import UserError
from deformpush.experiment.assemble import build_cell
from deformpush.mechanics.mesh import slab
from deformpush.mechanics.neo_hookean import cofactor
from deformpush.mechanics.strain import RestShape
from deformpush.worlds.mujoco.model import node_masses, rest_nodes
from deformpush.worlds.tool_motion import Line, ramp
from tests.setups import setup

BENCH = build_bench(["world=mujoco"])
OBJECTS = ("rect", "meat", "fish_fillet", "pork", "dough", "tofu", "silicone")


def with_masses(masses: str):
    return build_bench(["world=mujoco", f"world.engine.masses={masses}"])


@pytest.mark.parametrize("bench", [BENCH, build_bench(["world=mujoco", "object=fish_fillet"])])
def test_the_elastic_forces_are_those_of_the_law(bench):
    """Nodal forces -V P Dm^-T of Psi = mu/2 (I_C - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2."""
    body, sheet, rng = bench.on_table(bench.sheet), bench.sheet, np.random.default_rng(0)
    rest, (mu, lam) = body.nodes(), sheet.material.lame
    mesh = slab(sheet.polygon, sheet.thickness, sheet.cell)
    deformed = rest @ (np.eye(3) + rng.uniform(-0.3, 0.3, (3, 3))) + rng.normal(0, 2e-4, rest.shape)
    body.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    body.simulation.data.qpos[: rest.size] = (deformed - rest).ravel()
    mujoco.mj_forward(body.model, body.simulation.data)
    found = body.simulation.data.qfrc_spring[: rest.size].reshape(-1, 3)

    gradients = RestShape(mesh).gradients(deformed)
    J = np.linalg.det(gradients)[:, None, None]
    piola = mu * gradients + ((lam + mu) * (J - 1) - mu) * cofactor(gradients)
    first, *others = mesh.tetrahedra.T
    sides = np.stack([mesh.nodes[other] - mesh.nodes[first] for other in others], axis=-1)
    pulls = -mesh.volumes[:, None, None] * piola @ np.swapaxes(np.linalg.inv(sides), 1, 2)
    wanted = np.zeros_like(rest)
    for k, other in enumerate(others):
        np.add.at(wanted, other, pulls[:, :, k])
        np.add.at(wanted, first, -pulls[:, :, k])
    assert np.abs(wanted).max() > 0.1
    np.testing.assert_allclose(found, wanted, atol=1e-11)


@pytest.mark.parametrize("gate", [friction, stiffness, gates.weight], ids=lambda gate: gate.__name__)
def test_textbook(gate):
    result = gate(BENCH)
    assert result.passed, result


@pytest.mark.parametrize("by_volume", [False, True])
def test_masses_sum_up_to_the_objects(by_volume):
    sheet = BENCH.sheet
    mesh = slab(sheet.polygon, sheet.thickness, sheet.cell)
    masses = node_masses(mesh, 0.3, by_volume)
    assert masses.sum() == pytest.approx(0.3)
    assert (np.ptp(masses) < 1e-15) != by_volume


def test_masses_by_volume_have_their_centre_in_the_middle_of_the_volume():
    """Of an object whose nodes lie closer together at one end; equal masses have not."""
    sheet = build_bench(["world=mujoco", "object=fish_fillet"]).sheet
    mesh = slab(sheet.polygon, sheet.thickness, sheet.cell)
    corners = mesh.nodes[mesh.tetrahedra].mean(axis=1)
    middle = mesh.volumes @ corners / mesh.volumes.sum()
    by_volume, equal = (node_masses(mesh, 1.0, choice) @ mesh.nodes for choice in (True, False))
    np.testing.assert_allclose(by_volume, middle, atol=1e-12)
    assert np.linalg.norm(equal - middle) > 1e-4


def test_the_masses_are_the_configured_ones_and_turn_an_off_centre_push_further():
    turned = {}
    for masses in ("equal", "volume"):
        bench = with_masses(masses)
        body = bench.on_table(bench.sheet)
        np.testing.assert_allclose(body.masses, node_masses_of(bench, masses == "volume"))
        world = bench.world()
        world.push(bench.path(0.03, 0.02))
        side = rim(world.mesh, world.nodes())
        along = np.linalg.svd(side - centroid(side))[2][0]
        turned[masses] = abs(np.degrees(np.arctan(along[1] / along[0])))
    assert 0.5 < turned["volume"] - turned["equal"] < 2


def node_masses_of(bench, by_volume: bool) -> np.ndarray:
    mesh = slab(bench.sheet.polygon, bench.sheet.thickness, bench.sheet.cell)
    return node_masses(mesh, bench.sheet.material.total_mass(mesh.volumes.sum()), by_volume)


def test_a_push_through_the_middle_of_a_symmetric_object_does_not_turn_it():
    world = BENCH.world()
    before = rest_nodes(world.mesh, BENCH.sheet, BENCH.spec.margin)
    world.push(BENCH.path(0.03))
    moved = world.nodes() - before
    left, right = (moved[np.isclose(world.mesh.nodes[:, 0], x)][:, 1].mean() for x in (-0.1, 0.1))
    assert abs(np.degrees((right - left) / 0.2)) < 0.1


@pytest.mark.parametrize("name", OBJECTS)
def test_every_object_is_put_up_and_pushed(name):
    bench = build_bench(["world=mujoco", f"object={name}"])
    world = bench.world()
    outcome = world.push(bench.path(bench.sheet.d[0], 0.01))
    assert 0 < outcome.strain.p99_peak < 0.3
    assert 0 < outcome.tool_force_mean < outcome.tool_force_peak
    moved = centroid(rim(world.mesh, world.nodes())) - bench.sheet.start
    assert 0.3 < moved[1] / bench.sheet.d[0] < 1.1


def test_a_slow_tool_feels_friction_alone():
    """Mu m g = 0.981 N."""
    world = BENCH.world()
    material = BENCH.sheet.material
    line = Line(BENCH.path(0.015), 0.002)
    forces = []
    for s, v in ramp(line.length, 0.01, 1.5, world.simulation.dt):
        world.tool.follow(line.at(s - v * world.simulation.dt), v * line.direction)
        world.simulation.step()
        forces.append(world.simulation.tool_force())
    assert forces[0] == 0
    assert np.mean(forces[-40:]) == pytest.approx(material.friction * material.mass * 9.81, rel=0.03)


def test_the_force_is_the_sum_that_the_engine_itself_tells():
    world = BENCH.world()
    line = Line(BENCH.path(0.02, 0.03), 0.006)
    profile = ramp(line.length, 0.15, 1.5, world.simulation.dt)
    gates.carry(world, line, profile[: 2 * len(profile) // 3])
    model, data = world.simulation.model, world.simulation.data
    total, one = np.zeros(3), np.zeros(6)
    for i in range(data.ncon):
        if model.geom("tool").id in data.contact[i].geom:
            mujoco.mj_contactForce(model, data, i, one)
            total += data.contact[i].frame.reshape(3, 3).T @ one[:3]
    assert np.linalg.norm(total) > 0.5
    assert world.simulation.tool_force() == pytest.approx(np.linalg.norm(total))


def test_each_pair_of_surfaces_has_its_own_friction():
    """The table's is the object's alone; the tool's is the product of both."""
    world = BENCH.world()
    line = Line(BENCH.path(0.02), 0.006)
    profile = ramp(line.length, 0.15, 1.5, world.simulation.dt)
    gates.carry(world, line, profile[: 2 * len(profile) // 3])
    contact, mu = world.simulation.data.contact, BENCH.sheet.material.friction
    against_tool = (contact.geom == world.simulation.model.geom("tool").id).any(axis=1)
    assert 0 < against_tool.sum() < len(against_tool)
    np.testing.assert_allclose(contact.friction[~against_tool, :2], mu)
    np.testing.assert_allclose(contact.friction[against_tool, :2], mu * BENCH.tool.friction)


def test_a_larger_step_leads_to_the_same_push():
    ends = []
    for scale in (1.0, 2.0):
        bench = build_bench(["world=mujoco", f"world.engine.dt_scale={scale}"])
        world = bench.world()
        assert world.simulation.dt == pytest.approx(scale * bench.sheet.dt)
        outcome = world.push(bench.path(0.03, 0.02))
        ends.append([*centroid(rim(world.mesh, world.nodes())), outcome.strain.p99_peak / 100])
    np.testing.assert_allclose(*ends, atol=5e-4)


def test_a_solver_that_does_not_converge_is_an_error():
    world = BENCH.world()
    world.simulation.model.opt.iterations = 3
    with pytest.raises(WorldError, match=r"^the simulation cannot be trusted: MuJoCo warns: Inertia"):
        world.push(BENCH.path(0.02))


@pytest.mark.parametrize("entry", range(7))
def test_every_warning_is_an_error(entry, monkeypatch):
    world = BENCH.world()

    def step(model, data):
        data.warning[entry].number += 1

    monkeypatch.setattr(mujoco, "mj_step", step)
    with pytest.raises(WorldError, match="MuJoCo warns"):
        world.push(BENCH.path(0.02))


@pytest.mark.parametrize("speed", [np.nan, np.inf, 1e12, 1e3])
def test_an_explosion_is_an_error(speed):
    world = BENCH.world()
    world.simulation.data.qvel[30] = speed
    with pytest.raises(WorldError, match=r"^the simulation (exploded|cannot be trusted)"):
        world.push(BENCH.path(0.02))


def test_the_engine_says_nothing_and_writes_nothing(tmp_path):
    code = """
from deformpush.checks.by_world import build_bench
from deformpush.cell.world import WorldError
world = build_bench(["world=mujoco"]).world()
world.simulation.data.qvel[30] = float("nan")
try:
    world.simulation.step()
except WorldError:
    print("raised")
"""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
        check=True,
    )
    assert (done.stdout, done.stderr) == ("raised\n", "")
    assert not list(tmp_path.iterdir())


def test_an_engine_is_loaded_when_its_world_is_put_up():
    """Not by the package, nor by reading the settings of either."""
    code = """
import sys
from tests.setups import setup
for world in ("bullet", "mujoco"):
    setup(f"world={world}")
print(sorted({"pybullet", "mujoco"} & set(sys.modules)))
"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    )
    assert done.stdout == "[]\n"


def test_a_robot_that_it_has_not_is_refused():
    spec = setup("world=mujoco").world
    cartesian = type("Cartesian", (), {"tip_height": 0.001, "length": 0.1, "friction": 0.2})()
    with pytest.raises(ValueError, match=r"^has a BareTool or a KukaIiwa as its robot, and no Cartesian"):
        spec.build(BENCH.sheet, cartesian, BENCH.camera, 0.01)


def test_a_tool_held_over_the_object_is_refused_in_one_line():
    with pytest.raises(
        UserError, match=r"^world=mujoco: robot.tip_height = 0.01 must not exceed world.margin"
    ):
        build_cell(setup("world=mujoco", "robot.tip_height=0.01"))


def test_the_arms_tip_is_where_the_tool_is():
    arm = setup("robot=kuka_iiwa").robot
    world = replace(BENCH, tool=arm).world()
    path = BENCH.path(0.03, 0.02)
    outcome = world.push(path)
    assert outcome.tip_error < 1e-4
    from deformpush.worlds.arm.iiwa import Iiwa

    for moment in outcome.motion:
        tip, along = Iiwa(arm.length).tip(np.array(list(moment.joints.values())))
        np.testing.assert_allclose(tip, moment.tool, atol=1e-4)
        assert along[2] < -1 + 1e-5
    np.testing.assert_allclose(outcome.motion[-1].tool[:2], path.end, atol=2e-4)


def test_the_description_of_the_arm_is_written_when_asked_for_and_goes_with_the_world():
    world = replace(BENCH, tool=setup("robot=kuka_iiwa").robot).world()
    file = Path(world.scenery().arm_urdf)
    assert file.is_file()
    assert world.scenery().arm_urdf == str(file)
    world.close()
    assert not file.exists()
    assert BENCH.world().scenery().arm_urdf is None


@pytest.mark.parametrize("robot", ["tool", "kuka_iiwa"])
def test_it_keeps_the_contract(robot):
    found = {gate.name: gate.passed for gate in contract(["world=mujoco", f"robot={robot}"])}
    assert all(found.values()), found
    assert {"branches", "states", "push", "push out of reach"} <= set(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", OBJECTS)
def test_a_chain_of_random_pushes(name):
    result = gates.chain(build_bench(["world=mujoco", f"object={name}"]), pushes=30)
    assert result.passed, result
