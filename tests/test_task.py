"""Errors (1)-(4), the stop rule, the goal and its variations."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.cell.mask import MaskGrid
from deformpush.cell.observation import Observation
from deformpush.cell.variation import Draw, Jitter
from deformpush.errors import UserError
from deformpush.mechanics.geometry import resample, rotation
from deformpush.task import ERROR_COLUMNS, TERMS, TOTAL, Errors, Goal, Stop, Target, Task, Weights
from tests.pictures import RECT, placed
from tests.setups import setup

GRID = MaskGrid(size=0.36, pixel=0.001)
TASK = Task(
    goal=Goal(offset=(0.03, 0.2), turn_deg=0.0),
    weights=Weights(k_c=3.0, k_theta=0.7, k_gamma=1.3),
    stop=Stop(position_m=0.02, angle_deg=7.0, e_gamma=0.15),
    jitter=False,
    jitter_range=Jitter(position_m=0.01, angle_deg=10.0, material=0.2),
    stop_when="all",
    e_c_over="start",
    e_theta_sign="absolute",
)
START = (0.5, -0.1)
reals = st.floats(-0.3, 0.3)
angles = st.floats(-20, 20)


def observed(c, theta, outline=RECT):
    body = resample(outline, 128)
    gamma = GRID.draw(body)
    return Observation(body @ rotation(theta).T + c, np.array(c, float), theta, gamma, False)


def masked(*spans):
    """A target whose mask is rows of the grid, and observations of others."""
    masks = []
    for first, last in spans:
        mask = np.zeros((20, 20), bool)
        mask[first:last] = True
        masks.append(mask)
    return masks


@given(x=reals, y=reals)
def test_e_c_is_the_share_of_the_start_distance_left(x, y):
    target = TASK.target(observed(START, 0.0), GRID, Draw())
    errors = TASK.errors(observed((x, y), 0.0), target)
    distance = np.hypot(x - 0.53, y - 0.1)
    assert errors["position_error_m"] == pytest.approx(distance)
    assert errors["e_c"] == pytest.approx(distance / np.hypot(0.03, 0.2))


def test_e_c_is_1_at_the_start_and_0_at_the_goal():
    start = observed(START, 0.4)
    target = TASK.target(start, GRID, Draw())
    assert TASK.errors(start, target)["e_c"] == pytest.approx(1.0)
    assert TASK.errors(observed((0.53, 0.1), 0.4), target)["e_c"] == pytest.approx(0.0)


def test_e_c_over_the_goals_distance_from_the_origin():
    task = replace(TASK, e_c_over="goal")
    target = task.target(observed(START, 0.0), GRID, Draw())
    errors = task.errors(observed(START, 0.0), target)
    assert errors["e_c"] == pytest.approx(np.hypot(0.03, 0.2) / np.hypot(0.53, 0.1))


@given(theta=angles, goal=st.floats(-180, 180))
def test_e_theta_is_the_shorter_way_round_over_pi(theta, goal):
    task = replace(TASK, goal=Goal((0.0, 0.2), goal))
    target = task.target(observed(START, 0.3), GRID, Draw())
    e_theta = task.errors(observed(START, theta), target)["e_theta"]
    assert -1 <= e_theta < 1
    turn = theta - 0.3 - np.radians(goal)
    assert np.exp(1j * np.pi * e_theta) == pytest.approx(np.exp(1j * turn), abs=1e-9)


def test_e_gamma_is_the_differing_area_over_that_of_the_goal():
    goal, shifted, bigger, apart = masked((4, 10), (6, 12), (4, 13), (12, 18))
    target = Target(np.zeros(2), 0.0, goal, RECT, 1.0)

    def e_gamma(mask):
        return TASK.errors(replace(observed((0, 0), 0.0), gamma=mask), target)["e_gamma"]

    assert e_gamma(goal) == 0
    assert e_gamma(shifted) == pytest.approx(4 / 6)
    assert e_gamma(bigger) == pytest.approx(3 / 6)
    assert e_gamma(apart) == pytest.approx(2.0)


@given(x=reals, y=reals, theta=angles, turn=st.floats(-90, 90))
def test_the_total_error_is_the_weighted_sum(x, y, theta, turn):
    task = replace(TASK, goal=Goal((0.03, 0.2), turn, mask=(0.15, 0.13)))
    errors = task.errors(observed((x, y), theta), task.target(observed(START, 0.0), GRID, Draw()))
    e_c, e_theta, e_gamma = (errors[name] for name in ("e_c", "e_theta", "e_gamma"))
    assert e_gamma > 0.1
    assert errors.e_T == errors["e_T"] == pytest.approx(3.0 * e_c + 0.7 * abs(e_theta) + 1.3 * e_gamma)
    assert errors["angle_error_rad"] == pytest.approx(np.pi * e_theta)


def test_the_total_error_has_the_same_bits_on_every_python():
    """From Python 3.12 on `sum` makes up for its rounding errors."""
    weights = Weights(k_c=0.1, k_theta=0.2, k_gamma=0.3)
    assert weights.total(1.0, -1.0, 1.0) == 0.1 + 0.2 + 0.3 != 0.6


def changed(errors, **values):
    """Errors of which some have other values."""
    assert set(values) <= set(ERROR_COLUMNS)
    return Errors({**errors.values, **values})


AT_STOP = Errors(dict(zip(ERROR_COLUMNS, (0.1, 7 / 180, 0.15, 0.5, 0.02, float(np.radians(7))), strict=True)))
OVER = {"position_error_m": 0.0201, "angle_error_rad": float(np.radians(7.1)), "e_gamma": 0.151}


def test_all_errors_at_their_stops_is_reached():
    assert TASK.reached(AT_STOP)
    assert replace(TASK, stop_when="any").reached(AT_STOP)


@pytest.mark.parametrize("name", OVER)
def test_one_error_over_its_stop_matters_to_all_and_not_to_any(name):
    errors = changed(AT_STOP, **{name: OVER[name]})
    assert not TASK.reached(errors)
    assert replace(TASK, stop_when="any").reached(errors)


@pytest.mark.parametrize("name", OVER)
def test_one_error_at_its_stop_suffices_for_any(name):
    errors = changed(AT_STOP, **{n: v for n, v in OVER.items() if n != name})
    assert not TASK.reached(errors)
    assert replace(TASK, stop_when="any").reached(errors)
    assert not replace(TASK, stop_when="any").reached(changed(AT_STOP, **OVER))


def test_the_signed_angle_accepts_any_turn_clockwise():
    errors = changed(AT_STOP, angle_error_rad=-2.0)
    assert not TASK.reached(errors)
    assert replace(TASK, e_theta_sign="signed").reached(errors)
    assert not replace(TASK, e_theta_sign="signed").reached(changed(AT_STOP, angle_error_rad=0.13))


def test_a_goal_at_the_start_is_refused():
    task = replace(TASK, goal=Goal((0.0, 0.0005), 0.0))
    with pytest.raises(
        UserError, match=r"^task.goal.offset = \[0.0, 0.0005\]: puts the goal within 1 mm of the start"
    ):
        task.target(observed(START, 0.0), GRID, Draw())
    over_goal = replace(task, e_c_over="goal")
    assert over_goal.target(observed(START, 0.0), GRID, Draw()).length == pytest.approx(np.hypot(0.5, 0.0995))


def test_a_goal_at_the_origin_is_refused_where_it_divides():
    task = replace(TASK, goal=Goal((-0.5, 0.1), 0.0), e_c_over="goal")
    with pytest.raises(UserError, match="puts the goal within 1 mm of the table origin"):
        task.target(observed(START, 0.0), GRID, Draw())


def test_the_shape_at_the_start_is_the_goal_mask():
    start = observed(START, 0.6)
    target = TASK.target(start, GRID, Draw())
    assert TASK.errors(start, target)["e_gamma"] < 0.01
    expected = placed(resample(RECT, 128), 0.53, 0.1, np.degrees(0.6))
    np.testing.assert_allclose(target.outline, expected, atol=1e-12)


def test_a_rectangular_goal_mask_turned_to_the_goal_pose():
    task = replace(TASK, goal=Goal((0.0, 0.2), 30.0, mask=(0.15, 0.13)))
    target = task.target(observed(START, 0.1), GRID, Draw())
    assert target.gamma.sum() * 1e-6 == pytest.approx(0.15 * 0.13, rel=0.02)
    along = target.outline[1] - target.outline[0]
    assert np.linalg.norm(along) == pytest.approx(0.15)
    assert np.arctan2(along[1], along[0]) == pytest.approx(0.1 + np.pi / 6)
    np.testing.assert_allclose(target.outline.mean(axis=0), [0.5, 0.1])


def test_a_draw_moves_and_turns_the_goal():
    draw = Draw(goal_shift=(0.004, -0.006), goal_turn_deg=5.0)
    still, moved = (TASK.target(observed(START, 0.0), GRID, d) for d in (Draw(), draw))
    np.testing.assert_allclose(moved.c - still.c, [0.004, -0.006])
    assert moved.theta - still.theta == pytest.approx(np.radians(5))


@given(
    seed=st.integers(0, 10**6), position=st.floats(0, 0.05), angle=st.floats(0, 90), share=st.floats(0, 0.9)
)
def test_jitter_stays_within_its_range_and_follows_the_seed(seed, position, angle, share):
    jitter = Jitter(position, angle, share)
    draw = jitter.draw(np.random.default_rng(seed))
    assert np.abs([*draw.start_shift, *draw.goal_shift]).max() <= position
    assert np.abs([draw.start_turn_deg, draw.goal_turn_deg]).max() <= angle
    assert np.abs(np.subtract(draw.material, 1)).max() <= share + 1e-12
    assert jitter.draw(np.random.default_rng(seed)) == draw


def test_jitter_fills_its_range_both_ways():
    rng = np.random.default_rng(0)
    draws = [TASK.jitter_range.draw(rng) for _ in range(200)]
    flat = [
        (*d.start_shift, *d.goal_shift, d.start_turn_deg, d.goal_turn_deg, *np.subtract(d.material, 1))
        for d in draws
    ]
    limits = np.array([0.01] * 4 + [10.0] * 2 + [0.2] * 3)
    assert np.all(np.max(flat, axis=0) > 0.9 * limits)
    assert np.all(np.min(flat, axis=0) < -0.9 * limits)


def test_without_jitter_nothing_varies():
    assert TASK.draw(np.random.default_rng(1)) == Draw()
    jittered = replace(TASK, jitter=True)
    assert jittered.draw(np.random.default_rng(1)) == TASK.jitter_range.draw(np.random.default_rng(1))


def test_the_stop_groups_set_the_stop_values():
    paper, strict = (setup(f"stop={name}").task.stop for name in ("paper", "strict"))
    assert (paper.position_m, paper.angle_deg) == (0.02, 7.0)
    assert (strict.position_m, strict.angle_deg) == (0.01, 5.0)
    turn = next(term for term in TERMS if term.symbol == "e_theta")
    assert paper.value(turn) == pytest.approx(0.12217, abs=1e-5)


def test_every_error_has_a_weight_a_stop_value_and_columns_of_its_own():
    assert {term.weight for term in TERMS} == {item.name for item in fields(Weights)}
    assert {term.stop for term in TERMS} == {item.name for item in fields(Stop)} - {"on_damage"}
    assert list(ERROR_COLUMNS) == ["e_c", "e_theta", "e_gamma", "e_T", "position_error_m", "angle_error_rad"]
    assert len({quantity.colour for quantity in (*TERMS, TOTAL)}) == len(TERMS) + 1


def test_errors_are_shown_in_the_units_of_people():
    errors = changed(AT_STOP, angle_error_rad=-0.1, position_error_m=0.0123, e_gamma=0.0456)
    told = [term.show(errors.size(term)) for term in TERMS]
    assert told == ["12.3 mm", "5.7 deg", "0.046"]
    assert [term.label for term in TERMS] == ["position error (mm)", "angle error (deg)", "shape error (-)"]


def test_errors_that_no_model_forecasts_count_as_nothing():
    weights = Weights(k_c=3.0, k_theta=0.7, k_gamma=1.3)
    assert weights.total(0.5) == 1.5
    assert weights.total(0.5, -0.1) == pytest.approx(1.57)
    assert weights.total(np.array([0.5, 1.0]), 0.0, 1.0) == pytest.approx([2.8, 4.3])
