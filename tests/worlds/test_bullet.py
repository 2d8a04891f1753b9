"""The Bullet world: guard, bookkeeping, tool, arm, and what the camera sees of it."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.cell.push import ToolPath
from deformpush.cell.world import WorldError
from deformpush.checks.by_world import build_bench
from deformpush.checks.physics import centroid, rim
from deformpush.mechanics.geometry import signed_area
from deformpush.worlds.bullet.engine import Engine
from deformpush.worlds.bullet.world import _Line, _ramp
from tests import pictures
from tests.setups import setup

BENCH = build_bench([])
ARM = setup().robot
EYE = setup().contour


@pytest.fixture(scope="module")
def world():
    """A world with the bare tool, for tests that leave the object where it is."""
    world = BENCH.world()
    yield world
    world.close()


@pytest.fixture
def fresh():
    """A world to push in."""
    world = BENCH.world()
    yield world
    world.close()


@pytest.fixture
def with_arm():
    world = replace(BENCH, tool=ARM).world()
    yield world
    world.close()


def count_steps(world, monkeypatch):
    """A list that grows with every physics step of this world."""
    steps, whole = [], world.client.stepSimulation
    monkeypatch.setattr(world.client, "stepSimulation", lambda: steps.append(1) or whole(), raising=False)
    return steps


def sees(world, bench):
    """What perception makes of the picture, measured at half the object's height as in a run."""
    camera = replace(bench.camera, plane_z=bench.spec.margin + bench.sheet.thickness / 2)
    return EYE.observe(world.picture(), camera)


def test_the_guard_accepts_the_body_at_rest_and_what_a_push_does(world):
    nodes = world.nodes()
    world.body.check(nodes)
    world.body.check(nodes * (1.2, 0.9, 1.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda n: np.where(np.arange(len(n))[:, None] == 7, np.nan, n), "a node of the mesh is not finite"),
        (lambda n: n * (1, 1, -1), "volume ratios of tetrahedra run from -"),
        (lambda n: n * (1, 1, 3.2), "volume ratios of tetrahedra run from 3.2 to 3.2"),
        (lambda n: n * (2.1, 0.5, 1.0), "volume ratios of tetrahedra run from 1"),
    ],
    ids=["nan", "inverted", "swollen", "stretched"],
)
def test_the_guard_notices_an_explosion(change, message, world):
    with pytest.raises(WorldError, match=f"the simulation exploded: {message}"):
        world.body.check(change(world.nodes() - world.nodes().mean(axis=0)))


def test_a_time_step_beyond_stability_is_refused():
    with pytest.raises(
        ValueError, match=r"^dt: 0.021 s is unstable; it must not exceed twice damping = 0.02 s"
    ):
        Engine(dt=0.021, damping=0.01, gravity=9.81)


def test_the_engine_says_nothing_on_the_terminal():
    """Nor does its import, which only a fresh process shows."""
    code = "from deformpush.worlds.bullet.engine import connect; connect().disconnect(); print('said')"
    # Where Python does not buffer, C does not either, and nothing could be left over in its buffer.
    buffered = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=buffered)
    assert (done.stdout, done.stderr) == ("said\n", "")


def test_the_nodes_stand_where_the_sheet_puts_them(world):
    nodes, mesh = world.nodes(), world.mesh.nodes
    np.testing.assert_allclose(nodes[:, :2], mesh[:, :2] + BENCH.sheet.start, atol=1e-3)
    assert nodes[:, 2].min() == pytest.approx(BENCH.spec.margin, abs=5e-4)


def test_nothing_moves_between_pushes(fresh, monkeypatch):
    """Only a push steps the physics, and all its steps are counted, settling included."""
    steps = count_steps(fresh, monkeypatch)
    outcome = fresh.push(BENCH.path(0.015))
    assert outcome.steps == len(steps) > 0
    assert outcome.sim_s == pytest.approx(len(steps) * BENCH.spec.engine.dt)
    assert outcome.step_s > 0
    nodes = fresh.nodes()
    fresh.picture()
    fresh.joints()
    fresh.can_reach(np.zeros((4, 2)))
    fresh.scenery()
    np.testing.assert_array_equal(fresh.nodes(), nodes)
    assert len(steps) == outcome.steps
    assert len(outcome.motion) == BENCH.spec.motion.frames
    times = [m.time_s for m in outcome.motion]
    assert times == sorted(times)
    assert times[-1] < outcome.sim_s
    assert np.linalg.norm(outcome.motion[-1].tool[:2] - BENCH.path(0.015).end) < 2e-3


def test_a_push_moves_the_object_ahead_of_the_tool_and_no_further(fresh):
    before = centroid(rim(fresh.mesh, fresh.nodes()))
    path = BENCH.path(0.02)
    fresh.push(path)
    moved = centroid(rim(fresh.mesh, fresh.nodes())) - before
    assert 0.01 < moved[1] < 0.0205, "the object yields, so it moves by less than the tool does"
    assert abs(moved[0]) < 1e-3
    gap = np.linalg.norm(fresh.nodes()[:, :2] - path.end, axis=1).min() - BENCH.tool_radius
    assert abs(gap) < 3e-3, "it stays where the tool left it, but for the dent that springs back"


def test_the_strain_of_a_push_is_measured_while_it_lasts(fresh, monkeypatch):
    """Each peak is at least what any kept moment shows, and what stays is less."""
    looks, whole = [], fresh._gauge.__class__.look
    monkeypatch.setattr(
        fresh._gauge.__class__, "look", lambda self, nodes: looks.append(1) or whole(self, nodes)
    )
    outcome = fresh.push(BENCH.path(0.02))
    measured = outcome.strain
    assert 0 < measured.residual < measured.p99_peak < measured.max_peak < 1
    assert measured.residual < measured.top10_peak < measured.max_peak
    assert outcome.sim_s / len(looks) == pytest.approx(0.01, rel=0.25), "about every 10 ms"
    shown = [moment.strain.max() for moment in outcome.motion]
    assert max(shown) <= measured.max_peak + 0.01, "moments may lie between two samples"
    assert shown[-1] > 2 * shown[0], "the farther the tool has come"
    assert fresh.strain().shape == (len(fresh.nodes()),)
    assert fresh.strain().max() < measured.max_peak
    assert measured.at_nodes.shape == fresh.strain().shape
    assert measured.at_nodes.max() == measured.max_peak
    assert np.all(measured.at_nodes >= fresh.strain() - 0.01)
    assert (measured.limit, measured.exceeded) == (None, None)


def test_a_push_beyond_the_limit_is_told_from_one_within(fresh):
    fresh.strain_limit = 0.9
    assert fresh.push(BENCH.path(0.01)).strain.exceeded is False
    fresh.strain_limit = 0.01
    outcome = fresh.push(shifted(BENCH.path(0.01)))
    assert (outcome.strain.limit, outcome.strain.exceeded) == (0.01, True)


def test_measuring_moves_nothing():
    """The same push with and without a look at the strain ends with the same bits."""
    ends = []
    for every in (1, 10**9):
        world = BENCH.world()
        world._sample_every = every
        with pytest.MonkeyPatch.context() as patch:
            if every > 1:
                patch.setattr(world, "_measure", lambda outcome: None)
            world.push(BENCH.path(0.02))
        ends.append(world.nodes())
        world.close()
    np.testing.assert_array_equal(*ends)


def test_the_bare_tool_keeps_to_its_workspace(world):
    centre, reach = np.array(BENCH.tool.centre), BENCH.tool.reach
    points = centre + np.array([(0, 0), (0.99 * reach, 0), (0, -1.01 * reach)])
    assert world.can_reach(points).tolist() == [True, True, False]
    assert world.joints() == {}
    world.tool.place(centre)
    np.testing.assert_allclose(world.tool.tip(), [*centre, BENCH.tool.tip_height], atol=1e-9)
    world.tool.park()
    assert not BENCH.camera.sees(world.tool.tip()[:2])


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
    assert "tool_tip" in Path(scenery.arm_urdf).read_text()
    assert len(with_arm.joints()) == 7
    assert list(with_arm.joints().values()) == pytest.approx(ARM.park, abs=1e-4)
    assert scenery.mesh_triangles.max() < len(with_arm.nodes())


@given(
    length=st.floats(1e-3, 0.1),
    speed=st.floats(0.02, 0.5),
    acceleration=st.floats(0.2, 5),
    dt=st.floats(5e-4, 5e-3),
)
def test_the_tool_runs_from_rest_to_rest_within_its_limits(length, speed, acceleration, dt):
    s, v = _ramp(length, speed, acceleration, dt).T
    assert s[-1] == pytest.approx(length)
    np.testing.assert_allclose(
        np.cumsum(v) * dt, s, atol=1e-12
    )  # a step's speed is what carries it to its end
    assert v.min() >= -1e-12
    assert v.max() <= speed * (1 + 1e-9)
    assert np.abs(np.diff(v, prepend=0.0, append=0.0)).max() <= acceleration * dt * (1 + 1e-6)
    assert len(s) * dt >= length / speed


def test_the_executed_line_begins_before_the_touch_and_ends_with_the_push():
    path = ToolPath(np.array([0.5, 0.1]), np.array([0.6, 0.8]), 0.02, 0.03)
    way = _Line(path, 0.006)
    np.testing.assert_allclose(way.at(0.006), path.contact)
    np.testing.assert_allclose(way.at(way.length), path.end)
    assert way.length == pytest.approx(0.036)


@pytest.mark.parametrize("shape", [pictures.RECT, BENCH.sheet.polygon, pictures.lobed(0.08, 0.1, 3)])
def test_centroid_of_an_area(shape):
    np.testing.assert_allclose(centroid(shape + 0.3), pictures.centroid(shape + 0.3), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rect", "meat"])
@pytest.mark.parametrize(
    ("x", "y", "degrees"),
    [(0.58, 0.0, 0), (0.4, -0.15, 33), (0.72, 0.15, -70), (0.45, 0.2, 88), (0.75, -0.2, 10)],
)
def test_perception_against_the_mesh(name, x, y, degrees):
    bench = build_bench([f"object={name}", f"object.start=[{x},{y}]", f"object.start_deg={degrees}"])
    world = bench.world()
    truth = rim(world.mesh, world.nodes())
    seen = sees(world, bench)
    world.close()
    assert signed_area(seen.contour) == pytest.approx(signed_area(truth), rel=0.02)
    assert np.linalg.norm(seen.c - centroid(truth)) < 1e-3
    if name == "rect":
        assert np.degrees(seen.theta) == pytest.approx(degrees, abs=0.5)


@pytest.mark.slow
def test_the_arm_follows_its_path_and_pushes_as_the_bare_tool_does():
    ends = {}
    for name, tool in (("arm", ARM), ("tool", BENCH.tool)):
        world = replace(BENCH, tool=tool).world()
        outcomes = [world.push(BENCH.path(0.03)), world.push(shifted(BENCH.path(0.02)))]
        ends[name] = centroid(rim(world.mesh, world.nodes()))
        world.close()
        assert max(o.tip_error for o in outcomes) < 2e-3
    assert ends["arm"][1] > BENCH.sheet.start[1] + 0.015
    assert np.linalg.norm(ends["arm"] - ends["tool"]) < 4e-3


def shifted(path: ToolPath) -> ToolPath:
    """The second push: off the middle, and as far ahead as the first has moved the object."""
    return replace(path, start=np.add(path.start, (0.05, 0.025)))
