"""Outlines: which can be meshed, which way they run, and how thin they are."""

from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.mechanics.geometry import resample, rotation, signed_area
from deformpush.mechanics.outline import MAX_POINTS, contains, neck, simple
from tests.outlines import OUTLINES, RANDOM, disc, ell, rectangle, ring, star, tee

RECT = rectangle()


@pytest.mark.parametrize("name", OUTLINES)
def test_a_counter_clockwise_outline_is_taken_as_it_is(name):
    plan = simple(OUTLINES[name])
    assert not plan.reversed
    np.testing.assert_array_equal(plan.points, OUTLINES[name])
    assert plan.area == pytest.approx(signed_area(OUTLINES[name]))


@pytest.mark.parametrize("name", OUTLINES)
def test_a_clockwise_outline_is_reversed_and_that_is_told(name):
    plan = simple(OUTLINES[name][::-1])
    assert plan.reversed
    np.testing.assert_array_equal(plan.points, OUTLINES[name])
    assert plan.area > 0


def test_points_given_twice_in_a_row_are_dropped():
    """Files of polygons repeat the first point at the end."""
    np.testing.assert_array_equal(simple(np.concatenate([RECT, RECT[:1]])).points, RECT)
    np.testing.assert_array_equal(simple(np.repeat(RECT, 2, axis=0)).points, RECT)


@pytest.mark.parametrize(
    ("outline", "message"),
    [
        (RECT[[0, 2, 1, 3]], r"crosses or touches itself, sides 0 and 2 meet near \[0.1, -0.05\]"),
        (np.array([(0, 0), (0.1, 0), (0.05, 0), (0.05, 0.1)]), "crosses or touches itself, sides 0 and 1"),
        (np.array([(0, 0), (0.1, 0), (0.1, 0.1), (0.05, 0), (0, 0.1)]), "crosses or touches itself"),
        (np.array([(0, 0), (0.1, 0), (0.2, 0)]), r"covers no area, it reaches from \[0.0, 0.0\] to \[0.2, "),
        (np.array([(0, 0), (0.1, 0.1)]), "covers no area"),
        (np.array([(0, 0), (0.1, 0), (np.nan, 0.1)]), "a coordinate is not a finite number"),
        (np.array([(0, 0), (0.1, 0), (np.inf, 0.1)]), "a coordinate is not a finite number"),
        (RECT * 1000, "is 200 m long, must be 0.02 to 1 m; .* millimetres. Divide by 1000"),
        (RECT * 5.1, "is 1.02 m long, must be 0.02 to 1 m; its points are in metres$"),
        (RECT / 11, "is 0.0181818 m long"),
        (RECT.ravel(), r"must be points \[x, y\], not of shape \[8\]"),
        (disc(points=MAX_POINTS + 1), f"has {MAX_POINTS + 1} points; simplify it"),
    ],
)
def test_what_is_no_outline_is_refused_at_once(outline, message):
    began = process_time()
    with pytest.raises(ValueError, match=f"^outline: {message}"):
        simple(outline)
    assert process_time() - began < 1.0


def test_outlines_of_the_least_and_the_largest_size_are_taken():
    assert simple(RECT / 10).area > 0
    assert simple(RECT * 5).area > 0


def crosses(outline):
    """Whether any two sides meet, one pair at a time: parameters of the crossing of their lines."""
    n = len(outline)
    for i in range(n):
        for j in range(i + 2, n - (i == 0)):
            a, b, c, d = outline[i], outline[i + 1], outline[j], outline[(j + 1) % n]
            matrix = np.column_stack([b - a, c - d])
            if abs(np.linalg.det(matrix)) > 1e-14:
                s, t = np.linalg.solve(matrix, c - a)
                if 0 <= s <= 1 and 0 <= t <= 1:
                    return True
    return False


@settings(max_examples=200)
@given(seed=st.integers(0, 10**6), n=st.integers(3, 12))
def test_crossings_are_found_where_they_are(seed, n):
    outline = np.random.default_rng(seed).uniform(-0.2, 0.2, (n, 2))
    try:
        found = simple(outline) is None
    except ValueError as refused:
        found = "crosses" in str(refused)
    assert found == crosses(outline)


@pytest.mark.parametrize("turn", [0.0, np.pi / 4, np.pi / 2])
def test_a_comb_of_hundreds_of_teeth_is_checked_in_bounded_time(turn):
    """All teeth overlap along one axis, or along both when turned."""
    x = np.arange(499) * 8e-4
    across = np.repeat(x, 4) + np.tile([0, 0, 4e-4, 4e-4], 499)
    teeth = np.column_stack([across, np.tile([0, 0.3, 0.3, 0], 499)])
    outline = np.concatenate([[(x[-1], -0.05), (0, -0.05)], teeth]) @ rotation(turn).T
    began = process_time()
    assert simple(outline).reversed
    assert process_time() - began < 3.0


@settings(max_examples=50)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(sorted(RANDOM)))
def test_points_inside_are_told_by_the_angle_they_see_the_outline_under(seed, kind):
    rng = np.random.default_rng(seed)
    outline = RANDOM[kind](rng)
    lo, hi = outline.min(axis=0), outline.max(axis=0)
    points = rng.uniform(lo, hi, (40, 2))
    to = outline - points[:, None]
    around = np.arctan2(to[..., 1], to[..., 0])
    steps = (np.roll(around, -1, axis=1) - around + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_array_equal(contains(outline, points), np.abs(steps.sum(axis=1)) > np.pi)


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize(
    ("outline", "width"),
    [
        (RECT, 0.1),
        (rectangle(0.3, 0.02), 0.02),
        (disc(0.07), 0.14),
        (ell(0.16, 0.05), 0.05),
        (ell(0.2, 0.02), 0.02),
        (tee(0.16, 0.03), 0.03),
        (ring(270, 0.05, 0.1), 0.05),
        (ring(180, 0.08, 0.09), 0.01),
        (star(), 0.09),  # its tips are no necks: the disc within is the narrowest
    ],
)
def test_the_width_of_the_neck(outline, width, turn):
    assert neck(outline @ rotation(turn).T, 0.0025) == pytest.approx(width, rel=0.02)


def test_the_neck_between_two_notches_is_their_distance():
    """The outline is nowhere parallel there: no side faces another."""
    notched = np.array([(-0.1, -0.05), (0, -0.01), (0.1, -0.05), (0.1, 0.05), (0, 0.01), (-0.1, 0.05)])
    assert neck(notched, 0.0025) == pytest.approx(0.02, rel=1e-9)


def test_the_neck_between_a_notch_and_a_side_that_leans_is_found():
    """No side of the notch is parallel to it, but a direction between them is."""
    notched = np.array([(-0.1, -0.05), (0, -0.05), (0, -0.01), (0.1, -0.05), (0.1, 0.02), (-0.1, 0.02)])
    assert neck(notched, 0.0025) == pytest.approx(0.03, rel=0.01)


def test_a_waist_is_found_whatever_the_spacing_of_the_points():
    x = np.linspace(-0.1, 0.1, 81)
    half = 0.03 - 0.02 * np.exp(-((x / 0.03) ** 2))
    waist = np.concatenate([np.column_stack([x, -half]), np.column_stack([x, half])[::-1]])
    for points in (128, 400, 1000):
        assert neck(resample(waist, points), 0.002) == pytest.approx(0.02, rel=0.03)
