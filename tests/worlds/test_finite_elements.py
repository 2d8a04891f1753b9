"""Both engines: what a push does, counts and measures, where the tool goes, and what the camera sees."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deformpush.cell.push import ToolPath
from deformpush.cell.world import WorldError
from deformpush.checks.by_world import build_bench
from deformpush.checks.physics import centroid, rim
from deformpush.mechanics.geometry import signed_area
from deformpush.mechanics.rounding import STRAINS
from deformpush.mechanics.strain import Gauge
from tests import pictures
from tests.setups import setup

ENGINES = ("bullet", "mujoco")
BENCHES = {name: build_bench([f"world={name}"]) for name in ENGINES}
ARM = setup("robot=kuka_iiwa").robot
EYE = setup().contour


@pytest.fixture(scope="module", params=ENGINES)
def bench(request):
    return BENCHES[request.param]


@pytest.fixture(scope="module")
def world(bench):
    """A world with the bare tool, for tests that leave the object where it is."""
    world = bench.world()
    yield world
    world.close()


@pytest.fixture
def fresh(bench):
    """A world to push in."""
    world = bench.world()
    yield world
    world.close()


@pytest.fixture
def with_arm(bench):
    world = replace(bench, tool=ARM).world()
    yield world
    world.close()


def count_steps(world, monkeypatch):
    """A list that grows with every physics step of this world."""
    steps, whole = [], world.simulation.step
    monkeypatch.setattr(world.simulation, "step", lambda: steps.append(1) or whole())
    return steps


def shifted(path: ToolPath) -> ToolPath:
    """The second push: off the middle, and as far ahead as the first has moved the object."""
    return replace(path, start=np.add(path.start, (0.05, 0.025)))


def test_the_nodes_stand_where_the_sheet_puts_them(world, bench):
    nodes, mesh = world.nodes(), world.mesh.nodes
    np.testing.assert_allclose(nodes[:, :2], mesh[:, :2] + bench.sheet.start, atol=1e-3)
    assert nodes[:, 2].min() == pytest.approx(bench.spec.margin, abs=5e-4)


def test_an_object_that_starts_turned_is_turned(bench):
    turned = replace(bench, sheet=replace(bench.sheet, start_deg=30.0)).world()
    mesh = turned.mesh.nodes[:, :2]
    wanted = pictures.placed(mesh, *bench.sheet.start, 30.0)
    np.testing.assert_allclose(turned.nodes()[:, :2], wanted, atol=1e-3)
    turned.close()


def test_nothing_moves_between_pushes(fresh, bench, monkeypatch):
    """Only a push steps the physics, and all its steps are counted, settling included."""
    steps = count_steps(fresh, monkeypatch)
    outcome = fresh.push(bench.path(0.015))
    assert outcome.steps == len(steps) > 0
    assert outcome.sim_s == pytest.approx(len(steps) * fresh.simulation.dt)
    assert outcome.step_s > 0
    nodes = fresh.nodes()
    fresh.picture()
    fresh.joints()
    fresh.can_reach(np.zeros((4, 2)))
    fresh.scenery()
    np.testing.assert_array_equal(fresh.nodes(), nodes)
    assert len(steps) == outcome.steps
    assert len(outcome.motion) == bench.spec.motion.frames
    times = [m.time_s for m in outcome.motion]
    assert times == sorted(times)
    assert times[-1] < outcome.sim_s
    assert np.linalg.norm(outcome.motion[-1].tool[:2] - bench.path(0.015).end) < 2e-3


def test_a_push_moves_the_object_ahead_of_the_tool_and_no_further(fresh, bench):
    before = centroid(rim(fresh.mesh, fresh.nodes()))
    path = bench.path(0.02)
    fresh.push(path)
    moved = centroid(rim(fresh.mesh, fresh.nodes())) - before
    assert 0.01 < moved[1] < 0.0205, "the object yields, so it moves by less than the tool does"
    assert abs(moved[0]) < 1e-3
    gap = np.linalg.norm(fresh.nodes()[:, :2] - path.end, axis=1).min() - bench.tool_radius
    assert abs(gap) < 3e-3, "it stays where the tool left it, but for the dent that springs back"


def test_the_strain_of_a_push_is_measured_while_it_lasts(fresh, bench, monkeypatch):
    """Each peak is at least what any kept moment shows, and what stays is less."""
    looks, whole = [], Gauge.look
    monkeypatch.setattr(Gauge, "look", lambda self, nodes: looks.append(1) or whole(self, nodes))
    outcome = fresh.push(bench.path(0.02))
    measured = outcome.strain
    assert 0 < measured.residual < measured.p99_peak < measured.max_peak < 1
    assert measured.residual < measured.top10_peak < measured.max_peak
    dt = fresh.simulation.dt
    every = max(1, round(0.01 / dt)) * dt
    assert outcome.sim_s / len(looks) == pytest.approx(every, rel=0.05), "as near to 10 ms as steps come"
    shown = [moment.strain.max() for moment in outcome.motion]
    assert max(shown) <= measured.max_peak + 0.01, "moments may lie between two samples"
    assert shown[-1] > 2 * shown[0], "the farther the tool has come"
    assert fresh.strain().shape == (len(fresh.nodes()),)
    assert fresh.strain().max() < measured.max_peak
    assert measured.at_nodes.shape == fresh.strain().shape
    assert round(measured.at_nodes.max(), STRAINS) == measured.max_peak
    assert np.all(measured.at_nodes >= fresh.strain() - 0.01)
    assert (measured.limit, measured.exceeded) == (None, None)


def test_a_push_beyond_the_limit_is_told_from_one_within(fresh, bench):
    fresh.strain_limit = 0.9
    assert fresh.push(bench.path(0.01)).strain.exceeded is False
    fresh.strain_limit = 0.01
    outcome = fresh.push(shifted(bench.path(0.01)))
    assert (outcome.strain.limit, outcome.strain.exceeded) == (0.01, True)


def test_measuring_moves_nothing(bench):
    """The same push with and without a look at the strain ends with the same bits."""
    watched, other = bench.world(), bench.world()
    watched.push(bench.path(0.02))
    other.execution.push_unmeasured(bench.path(0.02))
    np.testing.assert_array_equal(watched.nodes(), other.nodes())
    for world in (watched, other):
        world.close()


def test_the_bare_tool_keeps_to_its_workspace(world, bench):
    centre, reach = np.array(bench.tool.centre), bench.tool.reach
    points = centre + np.array([(0, 0), (0.99 * reach, 0), (0, -1.01 * reach)])
    assert world.can_reach(points).tolist() == [True, True, False]
    assert world.joints() == {}
    world.tool.place(centre)
    np.testing.assert_allclose(world.tool.tip(), [*centre, bench.tool.tip_height], atol=1e-9)
    world.tool.park()
    assert not bench.camera.sees(world.tool.tip()[:2])


def test_a_path_out_of_the_workspace_is_refused_before_anything_moves(fresh, monkeypatch):
    steps, nodes = count_steps(fresh, monkeypatch), fresh.nodes()
    with pytest.raises(WorldError, match=r"^the tool cannot reach \(1\.\d+, 0.000\) m$"):
        fresh.push(ToolPath(np.array([1.3, 0.0]), np.array([-1.0, 0.0]), 0.01, 0.02))
    np.testing.assert_array_equal(fresh.nodes(), nodes)
    assert not steps


def test_a_path_out_of_the_arms_reach_is_refused_before_anything_moves(with_arm, monkeypatch):
    far = np.array([1.3, 0.0])
    assert with_arm.can_reach(np.array([[0.58, 0.0], far])).tolist() == [True, False]
    steps, joints, nodes = count_steps(with_arm, monkeypatch), with_arm.joints(), with_arm.nodes()
    with pytest.raises(WorldError, match=r"the arm cannot reach \(1\.\d+, 0.000\) m with the tool upright"):
        with_arm.push(ToolPath(far, np.array([-1.0, 0.0]), 0.01, 0.02))
    assert with_arm.joints() == joints
    np.testing.assert_array_equal(with_arm.nodes(), nodes)
    assert not steps


def test_the_arm_is_described_to_a_recorder(with_arm):
    scenery = with_arm.scenery()
    text = Path(scenery.arm_urdf).read_text()
    assert "tool_tip" in text
    assert len(with_arm.joints()) == 7
    assert all(f'<joint name="{name}" type="revolute">' in text for name in with_arm.joints())
    assert list(with_arm.joints().values()) == pytest.approx(ARM.park, abs=1e-4)
    assert scenery.mesh_triangles.max() < len(with_arm.nodes())


@pytest.mark.parametrize("shape", [pictures.RECT, pictures.lobed(0.08, 0.1, 3)])
def test_centroid_of_an_area(shape):
    np.testing.assert_allclose(centroid(shape + 0.3), pictures.centroid(shape + 0.3), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", ["rect", "meat"])
@pytest.mark.parametrize(
    ("x", "y", "degrees"),
    [(0.58, 0.0, 0), (0.4, -0.15, 33), (0.72, 0.15, -70), (0.45, 0.2, 88), (0.75, -0.2, 10)],
)
def test_perception_against_the_mesh(engine, name, x, y, degrees):
    place = [f"object.start=[{x},{y}]", f"object.start_deg={degrees}"]
    bench = build_bench([f"world={engine}", f"object={name}", *place])
    world = bench.world()
    truth = rim(world.mesh, world.nodes())
    # Measured at half the object's height, as in a run.
    camera = replace(bench.camera, plane_z=bench.spec.margin + bench.sheet.thickness / 2)
    seen = EYE.observe(world.picture(), camera)
    world.close()
    assert signed_area(seen.contour) == pytest.approx(signed_area(truth), rel=0.02)
    assert np.linalg.norm(seen.c - centroid(truth)) < 1e-3
    if name == "rect":
        assert np.degrees(seen.theta) == pytest.approx(degrees, abs=0.5)


@pytest.mark.slow
def test_the_arm_follows_its_path_and_pushes_as_the_bare_tool_does(bench):
    ends = {}
    for name, tool in (("arm", ARM), ("tool", bench.tool)):
        world = replace(bench, tool=tool).world()
        outcomes = [world.push(bench.path(0.03)), world.push(shifted(bench.path(0.02)))]
        ends[name] = centroid(rim(world.mesh, world.nodes()))
        world.close()
        assert max(o.tip_error for o in outcomes) < 2e-3
    assert ends["arm"][1] > bench.sheet.start[1] + 0.015
    assert np.linalg.norm(ends["arm"] - ends["tool"]) < 4e-3


@pytest.mark.slow
def test_both_engines_show_the_same_picture():
    """Of the same nodes: the rasteriser is compared with Bullet's renderer, pixel by pixel."""
    for place in ([0.58, -0.1], [0.4, -0.15], [0.75, 0.2]):
        worlds = [build_bench([f"world={name}", f"object.start={place}"]).world() for name in ENGINES]
        bullet, mujoco = worlds
        drawn = mujoco._draw(bullet.nodes())
        apart = (drawn != 255).any(axis=2) != (bullet.picture() != 255).any(axis=2)
        assert apart.sum() <= 5
        for world in worlds:
            world.close()
