"""Ends of the effective contour given as points and shares; what the tool cannot push is not on it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.cell.effective import BetweenPoints, BetweenShares, EffectiveContour
from deformpush.cell.push import Push
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import rotation
from tests.cell.test_orientation import EYE, look
from tests.outlines import OUTLINES, ell, rectangle

ALL = EffectiveContour(90.0, 450.0)
LAYOUT: Push = replace(config.build(compose([]).push), contact_margin=0.002)
CONCAVE = ("ell", "tee", "ring", "star", "kidney")


def at(seen, index):
    """A contour point in the object's frame."""
    return (seen.contour[index] - seen.c) @ rotation(seen.theta)


def test_points_are_of_the_outline_and_stay_on_the_object():
    part = BetweenPoints((-0.1, -0.05), (0.1, -0.05)).placed(np.array([0.5, -0.1]), 20.0)
    start = look(rectangle(), 0.5, -0.1, 20)
    for seen in (start, look(rectangle(), 0.6, 0.1, 75, start)):
        index = part.indices(seen)
        np.testing.assert_allclose(at(seen, index[[0, -1]]), [(-0.1, -0.05), (0.1, -0.05)], atol=0.006)
        assert at(seen, index)[:, 1] == pytest.approx(-0.05, abs=0.003)
    assert BetweenPoints((0.1, 0.0), (0.1, 0.0)).closed
    assert not part.closed


def test_shares_count_from_where_the_principal_direction_meets_the_contour():
    start = look(rectangle(), 0.5, -0.1, 0)
    side = BetweenShares(5 / 60, 25 / 60)  # of 0.6 m: the upper long side, from right to left
    np.testing.assert_allclose(
        at(start, side.indices(start)[[0, -1]]), [(0.1, 0.05), (-0.1, 0.05)], atol=0.006
    )
    assert BetweenShares(0.0, 1.0).closed
    with pytest.raises(ValueError, match="is first too; 0 and 1"):
        BetweenShares(0.5, 0.5)


@pytest.mark.parametrize("name", CONCAVE)
@pytest.mark.parametrize("augment", ["radial", "normal"])
@settings(max_examples=25)
@given(kappa=st.floats(0, 1))
def test_every_push_that_is_offered_meets_the_point_it_is_meant_for(name, augment, kappa):
    layout, seen = replace(LAYOUT, augment=augment), STARTS[name]
    line = layout.effective(seen, ALL)
    path = layout.plan(np.array([kappa, 0.02]), seen, ALL)
    low = int(line.at(kappa))
    wanted = seen.contour[line.index[[low, min(low + 1, len(line.index) - 1)]]]
    touched = np.linalg.norm(seen.contour - path.contact, axis=1).min()
    assert touched == pytest.approx(layout.reach, abs=layout.reach)
    assert np.linalg.norm(wanted - path.contact, axis=1).min() < 2.3 * layout.reach


STARTS = {name: look(OUTLINES[name], 0.58, 0.0, 0) for name in CONCAVE}


@pytest.mark.parametrize("name", ["ell", "tee", "ring"])
def test_what_cannot_be_pushed_is_left_out_and_takes_up_no_kappa(name):
    seen, layout = STARTS[name], replace(LAYOUT, augment="normal")
    line, can = layout.effective(seen, ALL), layout.pushable(seen.contour, seen.c)
    assert 0 < np.count_nonzero(~can) < 128
    assert set(line.index) == set(np.flatnonzero(can)) & set(ALL.indices(seen))
    gaps = (np.diff(line.index) % 128) != 1
    np.testing.assert_array_equal(np.diff(line.kappa)[gaps], 0.0)
    assert (np.diff(line.kappa)[~gaps] > 0).all()


def test_on_a_convex_object_nothing_is_left_out():
    seen = look(rectangle(), 0.58, 0.0, 0)
    np.testing.assert_array_equal(LAYOUT.effective(seen, ALL).index, ALL.indices(seen))


def test_where_contours_are_not_followed_nothing_is_left_out():
    seen = look(ell(), 0.58, 0.0, 0, eye=replace(EYE, angle="pca"))
    np.testing.assert_array_equal(LAYOUT.effective(seen, ALL).index, ALL.indices(seen))


def test_where_pushes_may_begin_does_not_jump_when_the_object_moves():
    first = STARTS["ell"]
    for degrees in (3, 50, 170):
        now = look(OUTLINES["ell"], 0.56, 0.02, degrees, first)
        was, moved = (LAYOUT.effective(seen, ALL) for seen in (first, now))
        np.testing.assert_array_equal(was.index, moved.index)
        places = [
            (line.places(50) - seen.c) @ rotation(seen.theta) for line, seen in ((was, first), (moved, now))
        ]
        assert np.linalg.norm(places[0] - places[1], axis=1).max() < 0.015
