"""The rigid body moves as the limit surface says, and no further than the tool makes it."""

import numpy as np
import pytest

from deformpush.mechanics.quasi_static import make_way, overlap, pushed
from tests.states import BODY

REACH = 0.01
BELOW = -0.05 - REACH  # the tool just touches the lower long side


def after(tool, pressure=0.06, pose=(0.0, 0.0, 0.0), body=BODY):
    return make_way(body, np.array([pose]), np.array([tool]), REACH, pressure)[0]


def test_what_is_not_touched_stays():
    assert after((0.0, BELOW - 1e-3)).tolist() == [0.0, 0.0, 0.0]


def test_a_push_through_the_centroid_moves_straight_on():
    x, y, turn = after((0.0, BELOW + 0.002))
    assert y == pytest.approx(0.002, abs=2e-6)
    assert abs(x) < 1e-9
    assert abs(turn) < 1e-9


@pytest.mark.parametrize("arm", [-0.07, 0.03, 0.07])
@pytest.mark.parametrize("pressure", [0.04, 0.08])
def test_speeds_are_those_of_the_limit_surface(arm, pressure):
    """V = s / (1 + a^2 / l^2) and omega = a v / l^2 for a push at speed s with lever arm a."""
    s = 1e-5
    _, y, turn = make_way(
        BODY, np.zeros((1, 3)), np.array([[arm, BELOW + s]]), REACH, pressure, within=1e-12
    )[0]
    assert y == pytest.approx(s / (1 + arm**2 / pressure**2), rel=1e-3)
    assert turn == pytest.approx(arm * y / pressure**2, rel=1e-3)


def test_a_turned_scene_moves_alike():
    turn, c = 0.7, np.array([0.3, -0.2])
    R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    tool = np.array([0.04, BELOW + 0.001])
    here = after(tool)
    there = after(R @ tool + c, pose=(*c, turn))
    np.testing.assert_allclose(there[:2], R @ here[:2] + c, atol=1e-9)
    assert there[2] - turn == pytest.approx(here[2], abs=1e-9)


def test_many_at_once_are_each_as_alone():
    tools = np.array([[0.05, BELOW + 0.001], [0.0, BELOW - 0.1], [-0.08, BELOW + 0.002]])
    pressures = np.array([0.05, 0.06, 0.07])
    # Which contacts end the rounds depends on the company: within the overlap that may stay.
    together = make_way(BODY, np.zeros((3, 3)), tools, REACH, pressures)
    for one, tool, pressure in zip(together, tools, pressures, strict=True):
        np.testing.assert_allclose(one, after(tool, pressure), atol=3e-5)


def test_the_tool_stays_outside_all_the_way():
    contact, direction = np.array([[0.06, BELOW], [-0.09, BELOW]]), np.array([[0.0, 1.0], [0.0, 1.0]])
    travel = np.linspace(0.0, 0.03, 16)
    poses = pushed(BODY, contact, direction, REACH, 0.06, travel)
    assert poses.shape == (2, 16, 3)
    for row, start in zip(poses, contact, strict=True):
        assert row[0].tolist() == [0.0, 0.0, 0.0]
        for pose, s in zip(row, travel, strict=True):
            assert overlap(BODY, pose, start + np.array([0.0, s]), REACH) < 1e-4
    assert poses[0, -1, 2] > 0.1
    assert poses[1, -1, 2] < -0.1
