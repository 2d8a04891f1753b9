"""The prior mean is the rigid body's motion, and its two numbers are found in the pushes."""

import numpy as np
import pytest

from deformpush.model.rigid_push import Experience, Lines, RigidPush
from tests.states import seen

OUTER = np.array([[0.0, 1.0], [0.01, 0.03]])
SPEC = RigidPush()


def experience(slip, pressure, pushes=8, seed=0):
    """Pushes of a body that is rigid but for the slip."""
    rng = np.random.default_rng(seed)
    known, Y = Experience(SPEC, 0.03, 300), []
    for _ in range(pushes):
        u = np.array([rng.random(), rng.uniform(0.015, 0.03)])
        state = seen(*rng.normal(0, 0.05, 3))
        known.keep(*known.table(state, u))
        travel = np.linspace(0.0, u[1] - slip, 12)
        Y.append(Lines.of(state, u[None]).pushed(pressure, travel)[0, -1])
    return known, np.array(Y)


UNIT = np.array([0.003, 0.003, 0.03])


@pytest.mark.parametrize(("slip", "pressure"), [(0.001, 0.8), (0.003, 1.2), (0.006, 1.0)])
def test_slip_and_pressure_radius_are_learnt(slip, pressure):
    known, Y = experience(slip, pressure, pushes=16)
    known.learn(Y, UNIT / 10)
    assert known.slip == pytest.approx(slip, abs=7e-4)
    assert known.pressure == pytest.approx(pressure, rel=0.1)
    assert np.all(np.abs(known.means() - Y) < (2e-3, 2e-3, 0.04))


def test_one_push_that_glanced_off_bends_neither():
    known, Y = experience(0.003, 1.0, pushes=16)
    Y[3] *= -3.0
    known.learn(Y, UNIT / 10)
    assert known.slip == pytest.approx(0.003, abs=1e-3)
    assert known.pressure == pytest.approx(1.0, rel=0.15)


def test_nothing_pushed_leaves_the_prior():
    known = Experience(SPEC, 0.03, 300)
    assert (known.slip, known.pressure) == (SPEC.slip[0], SPEC.pressure_radius[0])


def test_the_field_is_the_rigid_motion_between_lines_and_travels():
    known = Experience(SPEC, 0.03, 300)
    state = seen(0.1, 0.05, 0.3)
    field = known.field(state, OUTER, closed=True)
    U = np.array([[0.5, 0.025], [0.3, 0.02], [0.62, 0.012]])
    motion, _ = field.at(np.column_stack([U[:, 0], (U[:, 1] - 0.01) / 0.02]))
    for u, found in zip(U, motion, strict=True):
        travel = np.linspace(0.0, u[1] - known.slip, 12)
        exact = Lines.of(state, u[None]).pushed(known.pressure, travel)[0, -1]
        assert np.all(np.abs(found - exact) < (1e-3, 1e-3, 0.015))


def test_the_field_closes_on_itself_and_turns_with_the_object():
    known = Experience(SPEC, 0.03, 300)
    here, there = known.field(seen(), OUTER, True), known.field(seen(0.2, -0.1, 1.0), OUTER, True)
    ends = np.array([[0.0, 0.7], [1.0, 0.7]])
    np.testing.assert_array_equal(*here.at(ends)[0])
    U = np.random.default_rng(0).random((50, 2))
    np.testing.assert_allclose(here.at(U)[0], there.at(U)[0], atol=1e-9)


def test_slopes_are_those_of_finite_differences():
    field = Experience(SPEC, 0.03, 300).field(seen(), OUTER, True)
    U = np.random.default_rng(1).uniform(0.05, 0.95, (30, 2))
    _, slopes = field.at(U)
    for k in range(2):
        step = np.eye(2)[k] * 1e-7
        rise = (field.at(U + step)[0] - field.at(U - step)[0]) / 2e-7
        np.testing.assert_allclose(slopes[:, :, k], rise, atol=1e-5)


def test_memory_survives_saving():
    known, Y = experience(0.004, 0.9)
    again = Experience(SPEC, 0.03, 300)
    again.restore(known.state())
    for one in (known, again):
        one.learn(Y, UNIT)
    assert (again.slip, again.pressure) == (known.slip, known.pressure)
