"""The arm's own kinematics, its postures, and its description."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from deformpush.cell.world import WorldError
from deformpush.worlds.arm.iiwa import FLANGE, JOINTS, Iiwa
from deformpush.worlds.arm.posture_path import Planner
from deformpush.worlds.arm.urdf import urdf
from tests.setups import setup

SPEC = setup("robot=kuka_iiwa").robot
ARM = Iiwa(SPEC.length)
PLANNER = Planner(ARM, SPEC)
RNG = np.random.default_rng(0)
POSTURES = RNG.uniform(ARM.low, ARM.high, (20, 7))


def test_upright_it_is_as_long_as_its_parts():
    tip, along = ARM.tip(np.zeros(7))
    np.testing.assert_allclose(tip, [0, 0, 0.36 + 0.42 + 0.4 + 0.126 + SPEC.length], atol=1e-12)
    np.testing.assert_allclose(along, [0, 0, 1])


def test_stretched_out_it_reaches_as_far_as_the_data_sheet_says():
    """820 mm from the shoulder to the wrist."""
    assert sum(joint.offset for joint in JOINTS[2:]) == pytest.approx(0.82)
    q = np.array([np.pi / 2, np.pi / 2, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(ARM.tip(q)[0], [0, 0.82 + FLANGE + SPEC.length, 0.36], atol=1e-12)


@pytest.mark.parametrize("q", POSTURES)
def test_the_jacobian_is_the_slope_of_the_tip_and_of_the_tools_direction(q):
    """A turn w changes the direction a by w x a, whose height needs the x and y of w alone."""
    h = 1e-6
    ends = [[ARM.tip(q + s * h * axis) for s in (1, -1)] for axis in np.eye(7)]
    moved = np.array([(a[0] - b[0]) / (2 * h) for a, b in ends]).T
    risen = np.array([(a[1] - b[1])[2] / (2 * h) for a, b in ends])
    jacobian, (x, y, _) = ARM.jacobian(q), ARM.tip(q)[1]
    np.testing.assert_allclose(jacobian[:3], moved, atol=1e-8)
    np.testing.assert_allclose(jacobian[3] * y - jacobian[4] * x, risen, atol=1e-8)


def test_a_path_is_planned_upright_within_the_limits_and_interpolated():
    points = np.linspace([0.5, -0.2], [0.55, -0.15], 20)
    path = PLANNER.plan(points)
    for share in np.linspace(0, 1, 57):
        xy = (1 - share) * points[0] + share * points[-1]
        posture, slope = path.at(xy)
        tip, along = ARM.tip(posture)
        assert np.linalg.norm(tip - [*xy, SPEC.tip_height]) < 2e-4
        assert along[2] < -1 + 1e-5
        assert np.all((posture >= ARM.low) & (posture <= ARM.high))
        way = (points[-1] - points[0]) / np.linalg.norm(points[-1] - points[0])
        np.testing.assert_allclose((ARM.jacobian(posture)[:2] @ slope) @ way, way, atol=0.02)


def test_a_point_out_of_reach_is_named():
    with pytest.raises(WorldError, match=r"the arm cannot reach \(1.300, 0.000\) m with the tool upright"):
        PLANNER.plan(np.array([[0.5, 0.0], [1.3, 0.0]]))


def test_a_joint_that_would_flip_is_refused():
    with pytest.raises(WorldError, match=r"the arm would flip: a joint turns \d+ degrees within one step"):
        PLANNER.plan(np.array([[0.5, -0.3], [0.5, 0.3]]))


def test_the_description_has_the_joints_and_the_length_of_the_kinematics():
    robot = ET.fromstring(urdf(SPEC.length, 0.01))
    moving = [joint for joint in robot.iter("joint") if joint.get("type") == "revolute"]
    assert [joint.get("name") for joint in moving] == [joint.name for joint in JOINTS]
    for described, joint, high in zip(moving, JOINTS, ARM.high, strict=True):
        assert tuple(map(int, described.find("axis").get("xyz").split())) == joint.axis
        limit = described.find("limit")
        assert [float(limit.get(end)) for end in ("lower", "upper")] == pytest.approx([-high, high])
    height = sum(float(origin.get("xyz").split()[2]) for origin in robot.findall("joint/origin"))
    assert height == pytest.approx(ARM.tip(np.zeros(7))[0][2])
    links = {link.get("name") for link in robot.iter("link")}
    ends = {joint.find(end).get("link") for joint in robot.iter("joint") for end in ("parent", "child")}
    assert links == ends >= {"base", "tool", "tool_tip"}


def test_a_recorder_can_read_the_description(tmp_path):
    from rerun.urdf import UrdfTree

    file = tmp_path / "arm.urdf"
    file.write_text(urdf(SPEC.length, 0.01))
    tree = UrdfTree.from_file_path(str(file), entity_path_prefix="scene")
    assert tree.root_link().name == "base"
    assert len(tree.joints()) == 9


@pytest.fixture(scope="module")
def bullets():
    """The arm of `pybullet_data`."""
    pytest.importorskip("pybullet")
    from deformpush.worlds.bullet.arm import ArmDrive
    from deformpush.worlds.bullet.engine import connect

    drive = ArmDrive(SPEC, connect(), 0.01)
    yield drive
    drive.close()


@pytest.mark.parametrize("q", POSTURES)
def test_bullets_arm_has_its_tip_in_the_same_place(q, bullets):
    for mine, theirs in zip(ARM.tip(q), bullets._twin.tip(q), strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-6)
    np.testing.assert_allclose(ARM.jacobian(q), bullets._twin.jacobian(q), atol=1e-9)


def test_bullets_arm_reaches_as_far_to_a_few_millimetres(bullets):
    """Along rays from the middle of the table, out and in: the last reachable point."""

    def border(reach, ray: np.ndarray, near: float, far: float) -> float:
        """By bisection, to a millimetre."""
        while abs(far - near) > 1e-3:
            middle = (near + far) / 2
            near, far = (middle, far) if reach(middle * ray[None])[0] else (near, middle)
        return near

    for angle in np.radians([0, 25, -25, 50, -70]):
        ray = np.array([np.cos(angle), np.sin(angle)])
        for far in (1.2, 0.05):
            mine, theirs = (border(arm.can_reach, ray, 0.55, far) for arm in (PLANNER, bullets))
            assert abs(mine - theirs) < 3e-3
            assert abs(mine - far) > 0.05, "the border lies in between"
