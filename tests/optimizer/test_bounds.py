"""Bounds: never outside the outer limits, never inverted; constAdaption narrows and opens again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from deformpush.optimizer import Adaptive, Box, TrustRegion

CHOICES = [
    Box(d=(0.01, 0.03)),
    Adaptive(d=(0.01, 0.03), kappa=(0.2, 0.8), taper=0.0),
    Adaptive(d=(0.01, 0.03), taper=4.0),
    TrustRegion(d=(0.01, 0.03), kappa=(0.2, 0.8)),
]
histories = st.integers(0, 40).flatmap(
    lambda S: st.tuples(
        arrays(float, (S, 2), elements=st.floats(0, 1)), arrays(float, S, elements=st.floats(-1, 1))
    )
)


@pytest.mark.parametrize("bounds", CHOICES, ids=str)
@given(history=histories, share=st.none() | st.floats(0, 20))
def test_inside_the_outer_limits_with_a_minimum_width(bounds, history, share):
    unit, xi = history
    lo, hi = bounds.outer.T
    now = bounds.now(lo + unit * (hi - lo), xi, share)
    assert now.shape == (2, 2)
    assert (now[:, 0] >= lo).all()
    assert (now[:, 1] <= hi).all()
    assert (now[:, 1] - now[:, 0] >= 0.1 * (hi - lo) - 1e-12).all()


def test_adaptive_narrows_around_what_works_and_opens_when_it_stops():
    bounds = Adaptive(d=(0.01, 0.03))
    good = np.tile([[0.4, 0.02]], (8, 1))
    narrow = bounds.now(good, np.full(8, -0.1))
    np.testing.assert_allclose(narrow[0], [0.3, 0.5], atol=0.02)
    np.testing.assert_allclose(narrow[1], [0.018, 0.022], atol=0.0004)
    failing = bounds.now(np.tile(good[:1], (11, 1)), np.r_[np.full(8, -0.1), 0.02, 0.02, 0.02])
    np.testing.assert_allclose(failing, bounds.outer)


def test_adaptive_follows_the_most_effective():
    bounds = Adaptive(d=(0.01, 0.03), elite=1)
    U = np.array([[0.1, 0.02], [0.9, 0.02], [0.5, 0.02]] * 2)
    now = bounds.now(U, np.array([-0.09, -0.1, -0.08] * 2))
    assert now[0, 1] == 1.0
    assert now[0, 0] > 0.7


def test_before_anything_works_the_bounds_are_the_outer_limits():
    bounds = Adaptive(d=(0.01, 0.03))
    U = np.full((3, 2), 0.02)
    np.testing.assert_array_equal(bounds.now(U[:0], np.empty(0)), bounds.outer)
    np.testing.assert_array_equal(bounds.now(U, np.array([0.1, 0.0, 0.2])), bounds.outer)


@pytest.mark.parametrize("kind", [Box, Adaptive, TrustRegion])
@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"d": (0.03, 0.01)}, r"^d: \[0.03, 0.01\] must satisfy 0 < d_min < d_max"),
        ({"d": (0.02, 0.02)}, "^d: "),
        ({"d": (0.0, 0.02)}, "^d: "),
        ({"d": (0.01, float("nan"))}, "^d: "),
        ({"d": (0.01, 0.03), "kappa": (0.6, 0.4)}, "^kappa: "),
        ({"d": (0.01, 0.03), "kappa": (0.0, 1.2)}, "^kappa: "),
    ],
)
def test_impossible_limits_are_named(kind, limits, message):
    with pytest.raises(ValueError, match=message):
        kind(**limits)


def test_taper_lowers_d_max_near_the_goal_only():
    bounds = Adaptive(d=(0.01, 0.03), taper=4.0)
    U, xi = np.tile([[0.4, 0.03]], (8, 1)), np.full(8, -0.1)
    far, near, there = (bounds.now(U, xi, share)[1, 1] for share in (8.0, 2.0, 0.0))
    assert (far, near, there) == (0.03, pytest.approx(0.02), pytest.approx(0.012))
    np.testing.assert_array_equal(bounds.now(U, xi), bounds.now(U, xi, 8.0))


def walk(steps):
    """A history whose xi improves (True) or not (False) at every step, at pushes near (0.5, 0.02)."""
    xi, best = [0.0], 0.0
    for better in steps:
        best -= 0.1 * better
        xi.append(best if better else 1.0)
    return np.tile([[0.5, 0.02]], (len(xi), 1)), np.array(xi)


def test_trust_region_grows_shrinks_and_starts_anew():
    region = TrustRegion(d=(0.01, 0.03), length=0.4)

    def side(*steps):
        now = region.now(*walk(steps))
        np.testing.assert_allclose(np.diff(now)[1, 0] / 0.02, np.diff(now)[0, 0], atol=1e-12)
        return np.diff(now)[0, 0]

    assert side() == pytest.approx(0.4)
    assert side(*[True] * 3) == pytest.approx(0.8)
    assert side(*[True] * 2, False, True) == pytest.approx(0.4), "in a row"
    assert side(*[True] * 6) == pytest.approx(1.0), "never beyond the outer limits"
    assert side(*[False] * 4) == pytest.approx(0.2)
    assert side(*[False] * 8) == pytest.approx(0.1)
    assert side(*[False] * 12) == pytest.approx(1.0), "below the shortest it starts anew"


def test_trust_region_is_centred_on_the_best_push():
    U = np.array([[0.2, 0.02], [0.6, 0.015], [0.9, 0.03]])
    now = TrustRegion(d=(0.01, 0.03), length=0.2).now(U, np.array([0.1, -0.2, 0.3]))
    np.testing.assert_allclose(now.mean(axis=1), [0.6, 0.015])


def test_trust_region_lengths_in_order():
    with pytest.raises(ValueError, match="length"):
        TrustRegion(d=(0.01, 0.03), length=0.05)
