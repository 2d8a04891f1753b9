"""The toy world moves its slab as quasi-static pushing says."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.cell.push import ToolPath
from deformpush.cell.world import World
from deformpush.experiment.assemble import build_cell
from tests.setups import setup

MADE = setup("world=toy", "robot=tool", "optimizer=random")
CELL = build_cell(MADE)
REACH = CELL.layout.tool_radius  # the toy has no margin
START = np.array([0.58, -0.1])


@pytest.fixture
def world():
    return build_cell(MADE).world


def north(x: float, d: float) -> ToolPath:
    """A push in y against the lower long side, `x` right of its middle."""
    x, y = START[0] + x, START[1] - 0.05 - REACH
    return ToolPath(np.array([x, y - 0.01]), np.array([0.0, 1.0]), 0.01, d)


def test_a_push_through_the_centroid_moves_by_d(world):
    world.push(north(0.0, 0.03))
    np.testing.assert_allclose(world.c - START, [0, 0.03], atol=1e-3)  # the outline has points 2.3 mm apart
    assert world.theta == pytest.approx(0, abs=5e-3)


def test_a_tool_that_does_not_touch_moves_nothing(world):
    world.push(replace(north(0.0, 0.0), approach=0.0095))
    np.testing.assert_array_equal(world.c, START)


def test_a_rigid_slab_has_no_strain(world):
    assert world.push(north(0.0, 0.02)).strain is None
    assert world.strain() is None


@pytest.mark.parametrize(("x", "sign"), [(0.06, 1), (-0.06, -1)])
def test_a_push_off_the_centroid_turns_the_object_away(world, x, sign):
    world.push(north(x, 0.03))
    assert sign * world.theta > np.radians(5)
    assert 0 < world.c[1] - START[1] < 0.03


def test_mirrored_pushes_have_mirrored_effects():
    poses = []
    for x in (0.05, -0.05):
        world = build_cell(MADE).world
        world.push(north(x, 0.02))
        poses.append((world.theta, *(world.c - START)))
    (turn, dx, dy), (turn_m, dx_m, dy_m) = poses
    assert (turn, dx, dy) == pytest.approx((-turn_m, -dx_m, dy_m), abs=1e-3)


def test_the_tool_ends_outside_the_object(world):
    path = north(0.04, 0.035)
    world.push(path)
    plan = world.nodes()[:, :2]
    assert np.linalg.norm(plan - path.end, axis=1).min() > REACH - 1e-3


def test_the_same_pushes_lead_to_the_same_pose():
    worlds = [build_cell(MADE).world for _ in range(2)]
    for world in worlds:
        for x in (0.05, -0.03):
            world.push(north(x, 0.015))
    np.testing.assert_array_equal(worlds[0].c, worlds[1].c)
    assert worlds[0].theta == worlds[1].theta


def test_the_camera_sees_the_pose_and_the_mesh_follows(world):
    before = CELL.perception.observe(world.picture(), CELL.camera)
    start = world.nodes()
    world.push(north(0.06, 0.03))
    after = CELL.perception.observe(world.picture(), CELL.camera, before)
    np.testing.assert_allclose(after.c, world.c, atol=1e-3)
    assert after.theta == pytest.approx(world.theta, abs=0.01)
    np.testing.assert_allclose(world.nodes()[:, :2].mean(axis=0), world.c, atol=1e-9)
    lengths = [np.linalg.norm(n[::7] - n[0], axis=1) for n in (start, world.nodes())]
    np.testing.assert_allclose(*lengths, atol=1e-12)


def test_what_a_push_reports(world):
    outcome = world.push(north(0.0, 0.02))
    assert outcome.steps == 30  # 10 mm to the touch and 20 mm on, a millimetre each
    assert [round(m.time_s, 6) for m in outcome.motion] == pytest.approx([0.007, 0.015, 0.022, 0.03])
    np.testing.assert_allclose(outcome.motion[-1].tool[:2], north(0.0, 0.02).end, atol=1e-12)
    np.testing.assert_array_equal(outcome.motion[-1].nodes, world.nodes())


def test_it_offers_what_the_loop_asks_of_a_world(world):
    assert isinstance(world, World)
    assert world.offers == {"film", "branches", "states"}
    assert world.can_reach(np.zeros((3, 2))).tolist() == [True] * 3
    assert world.joints() == {}
    assert world.scenery().mesh_triangles.max() < len(world.nodes())
    world.close()


def test_a_state_is_returned_to(world):
    world.push(north(0.01, 0.02))
    state, nodes = world.save(), world.nodes()
    world.push(north(0.0, 0.03))
    world.restore(state)
    np.testing.assert_array_equal(world.nodes(), nodes)
    assert world.save() == state


@pytest.mark.parametrize(
    ("harm", "message"),
    [
        (lambda state: b"", "no state of world=toy"),
        (lambda state: b"deformpush mujoco" + state[17:], "no state of world=toy"),
        (lambda state: state[:30] + bytes([state[30] ^ 1]) + state[31:], "a state of another world"),
        (lambda state: state[:-8], "a damaged state: it has not the length"),
        (lambda state: state[:-8] + np.float64(np.inf).tobytes(), "a damaged state: not all"),
        (lambda state: state[:-24] + np.float64(1e9).tobytes() + state[-16:], "a damaged state: the object"),
    ],
)
def test_what_is_no_state_is_refused(harm, message, world):
    before = world.save()
    with pytest.raises(ValueError, match=f"^{message}"):
        world.restore(harm(before))
    assert world.save() == before
