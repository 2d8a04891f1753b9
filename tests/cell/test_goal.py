"""A goal given as a pose or as an outline, and what an error comes to on a symmetric or a round object."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.cell.goal import Goal
from deformpush.cell.variation import Draw
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import rotation
from deformpush.task import SHAPE, TERMS, Task, TotalError
from tests.cell.test_orientation import EYE, look
from tests.outlines import OUTLINES, disc, rectangle
from tests.pictures import placed

TASK: Task = config.build(compose([]).task)
ANGLE = TERMS[1].column
FAR = Draw(goal_shift=(0.01, 0.02), goal_turn_deg=5.0)


def goal(**given):
    return replace(TASK, goal=Goal((0.0, 0.2), 0.0, **given))


def test_a_pose_is_where_it_says_whatever_the_seed_varies():
    start = look(rectangle(), 0.5, -0.1, 20)
    target = goal(pose=(0.6, 0.1, 45.0)).target(start, EYE.mask, FAR)
    np.testing.assert_allclose(target.c, (0.6, 0.1))
    assert np.degrees(target.theta) == pytest.approx(45)
    np.testing.assert_allclose(target.outline_body, start.body, atol=1e-6)


@pytest.mark.parametrize("name", ["ell", "fish", "tee"])
@pytest.mark.parametrize("degrees", [-150, 30, 120])
def test_an_object_that_lies_in_the_outline_is_at_its_goal(name, degrees):
    shape = OUTLINES[name]
    task = goal(outline=tuple(map(tuple, placed(shape, 0.6, 0.12, degrees).tolist())))
    start = look(shape, 0.5, -0.1, 20)
    target = task.target(start, EYE.mask, FAR)
    errors = task.errors(look(shape, 0.6, 0.12, degrees, start), target)
    assert errors["position_error_m"] < 2e-3, "tips are rounder in a picture of 1.5 mm a pixel"
    assert abs(np.degrees(errors[ANGLE])) < 0.6
    assert errors[SHAPE.column] < 0.05
    assert task.errors(start, target)["position_error_m"] > 0.1
    assert task.goal.setting == f"task.goal.outline = {len(shape)} points"


def test_an_outline_may_be_of_another_shape():
    start = look(rectangle(0.2, 0.1), 0.5, -0.1, 0)
    square = tuple(map(tuple, placed(rectangle(0.14, 0.14), 0.6, 0.1, 0).tolist()))
    task = goal(outline=square)
    assert task.errors(start, task.target(start, EYE.mask, FAR))[SHAPE.column] > 0.2


def test_a_goal_is_told_once():
    with pytest.raises(ValueError, match="pose: says where the goal is, and so does outline or picture"):
        goal(pose=(0.6, 0.1, 0.0), outline=((0.0, 0.0), (0.1, 0.0), (0.0, 0.1)))
    with pytest.raises(ValueError, match="crosses or touches itself"):
        goal(outline=((0.0, 0.0), (0.1, 0.1), (0.1, 0.0), (0.0, 0.1)))


def test_a_rectangle_turned_by_half_a_circle_is_at_its_goal():
    start = look(rectangle(), 0.5, -0.1, 0)
    task = replace(TASK, goal=Goal((0.05, 0.2), 175.0))
    target = task.target(start, EYE.mask, Draw())
    now = look(rectangle(), 0.55, 0.1, -5, start)
    assert abs(np.degrees(task.errors(now, target)[ANGLE])) < 0.3
    e_T = TotalError(target, task.weights)(*target.c, target.theta + np.pi * np.array([-1.0, 0.5]), 0.0)
    assert e_T == pytest.approx([0.0, task.weights.k_theta / 2], abs=1e-9)


def test_a_round_object_has_no_error_of_the_angle_and_reaches_its_goal_without():
    start = look(disc(), 0.5, -0.1, 0)
    target = TASK.target(start, EYE.mask, Draw())
    errors = TASK.errors(start, target)
    assert np.isnan(errors["e_theta"])
    assert np.isnan(errors[ANGLE])
    assert TERMS[1].show(errors.size(TERMS[1])) == "none"
    assert errors.e_T == pytest.approx(TASK.weights.k_c, abs=0.1)
    assert not TASK.reached(errors)
    assert TASK.reached(TASK.errors(look(disc(), 0.5, 0.1, 0, start), target))
    at = TotalError(target, TASK.weights)(*target.c, np.array([0.0, 1.0]), 0.0)
    assert at == pytest.approx([0.0, 0.0])


def test_the_turn_of_the_table_does_not_matter():
    """The same goal outline and object, both turned about the origin."""
    shape, errors = OUTLINES["ell"], []
    for degrees in (0, 60):
        turn = rotation(np.radians(degrees))
        start = look(shape, *(turn @ (0.1, -0.05) + (0.5, 0)), degrees)
        outline = (placed(shape, 0.15, 0.08, 40) @ turn.T + (0.5, 0)).tolist()
        task = goal(outline=tuple(map(tuple, outline)))
        errors.append(task.errors(start, task.target(start, EYE.mask, FAR)))
    assert errors[0]["position_error_m"] == pytest.approx(errors[1]["position_error_m"], abs=1e-3)
    assert errors[0][ANGLE] == pytest.approx(errors[1][ANGLE], abs=np.radians(1))
