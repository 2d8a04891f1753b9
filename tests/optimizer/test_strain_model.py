"""What is learnt of the strain that pushes cause: by place, and by speed.

Also of `optimizer/strain_trend.py`.
"""

import numpy as np
import pytest

from deformpush.optimizer.safe import Safe

from .fragile_cases import CAREFUL, MADE_OF, D, state


def difference_between_places(signal: str) -> float:
    """What the model makes of two places where the peaks of two pushes each differ, as a share of that."""
    model = Safe(limit=0.1, fit=CAREFUL, signal=signal, contour_scatter=0.3).constraint(MADE_OF)
    U = np.array([[0.3, 0.0], [0.7, 0.0]])
    for which in [0, 1] * 2:
        model.keep((0.06 if which else 0.08, 0.0))
    mu, _ = model.feasible(np.tile(U, (2, 1))).peak(U)
    return float((mu[0] - mu[1]) / np.log(0.08 / 0.06))


def test_places_are_told_apart_by_strain_and_not_by_dents():
    assert difference_between_places("strain") > 0.9
    assert abs(difference_between_places("contour")) < 0.1


def safe_set_of_impacts(speeds):
    """What is allowed after pushes at these speeds, each of which strains 0.05 (1 + (v / 0.15)^2)^0.6."""
    model = Safe(limit=0.1, speed=(0.03, 0.15), fit=CAREFUL).constraint(MADE_OF)
    for v in speeds:
        model.keep((0.05 * (1.0 + (v / 0.15) ** 2) ** 0.6, v))
    return model.feasible(np.random.default_rng(1).uniform(0, 1, (len(speeds), 2)))


def test_the_impact_is_learnt():
    learnt = safe_set_of_impacts(np.resize([0.03, 0.06, 0.1, 0.15], 30)).learnt
    assert 1.0 + learnt.beta[1] == pytest.approx(0.6, abs=0.08)
    assert np.sqrt(learnt.doubt[1, 1]) < 0.15, "1 / 2 before any push"


def test_what_is_not_known_of_the_impact_widens_the_bound_of_faster_pushes():
    slow, mixed = safe_set_of_impacts([0.03] * 20), safe_set_of_impacts(np.resize([0.03, 0.15], 20))
    at = np.array([[0.4, 0.5]])
    wider = [float(known.peak(at, 0.12)[1][0] - known.peak(at, 0.03)[1][0]) for known in (slow, mixed)]
    assert wider[0] > 0.05 > wider[1] + 0.02


def test_a_world_that_knows_no_speed_pushed_at_the_fastest():
    free, fixed = (Safe(limit=0.1, speed=speed).constraint(MADE_OF) for speed in ((0.03, 0.15), None))
    assert free.observe(state(), state(0.05)) == (0.05, 0.15)
    assert free.observe(state(), state(0.05, 0.04)) == (0.05, 0.04)
    assert fixed.observe(state(), state(0.05, 0.04)) == (0.05, 0.0)


def test_the_trend_grows_with_length_and_speed_as_it_says():
    trend = Safe(limit=0.1, growth=0.5, speed=(0.03, 0.15)).constraint(MADE_OF)._trend
    U = np.array([[0.2, 0.0], [0.2, 1.0]])
    slow, fast = trend.expected(U, 0.0), trend.expected(U, 0.15)
    np.testing.assert_allclose(slow, np.log(0.1) + 0.5 * np.log([D[0] / D[1], 1.0]))
    np.testing.assert_allclose(fast - slow, np.log(2.0))
    step = np.array([0.0, 1e-6])
    numeric = (trend.expected(U + step, 0.0) - trend.expected(U - step, 0.0)) / 2e-6
    np.testing.assert_allclose(trend.slope(U), numeric, rtol=1e-6)
