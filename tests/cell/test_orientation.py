"""Angles by laying the first contour on the one seen: whole circle, symmetries, where it begins."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.cell.perception import Perception
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.registration import ROUND
from tests.outlines import OUTLINES, disc, ell, rectangle, tee
from tests.pictures import picture, placed

CFG = compose([])
CAMERA = config.build(CFG.camera)
EYE: Perception = config.build(CFG.contour)


def look(shape, x, y, degrees, previous=None, eye=EYE):
    return eye.observe(picture(CAMERA, placed(shape, x, y, degrees)), CAMERA, previous)


def turned(shape, degrees, eye=EYE):
    """What is seen first, and after a turn in one go."""
    first = look(shape, 0.55, 0.0, 10, eye=eye)
    return first, look(shape, 0.6, 0.05, 10 + degrees, first, eye)


@pytest.mark.parametrize("name", ["ell", "tee", "ring", "kidney", "fish"])
@pytest.mark.parametrize("degrees", [-170, -100, 65, 90, 180])
def test_the_angle_is_found_over_the_whole_circle(name, degrees):
    first, now = turned(OUTLINES[name], degrees)
    off = (np.degrees(now.theta - first.theta) - degrees + 180) % 360 - 180
    assert abs(off) < 0.6


@pytest.mark.parametrize("name", ["ell", "tee", "ring", "fish"])
def test_a_point_of_the_contour_keeps_its_number(name):
    """It jumps by up to 194 mm on a thin L where the contour begins in a direction from the centroid."""
    shape = OUTLINES[name]
    first = look(shape, 0.58, 0.0, 0)
    for degrees in (5, 40, 130, 250):
        now = look(shape, 0.55, 0.03, degrees, first)
        off = np.linalg.norm(now.body - first.body, axis=1)
        assert off.max() < 0.009, "two points of 128"
        assert np.median(off) < 0.004


def test_a_rectangle_turned_by_half_a_circle_looks_the_same():
    first, now = turned(rectangle(), 180)
    assert first.first.order == 2
    assert abs(np.degrees(now.theta - first.theta)) < 0.3
    first, now = turned(rectangle(), 70)
    assert np.degrees(now.theta - first.theta) == pytest.approx(70, abs=0.3)


def test_an_order_that_is_given_counts():
    eye = replace(EYE, symmetry=1)
    first, _ = turned(rectangle(0.2, 0.12), 130, eye)
    assert first.first.order == 1
    assert look(rectangle(), 0.5, 0, 0, eye=replace(EYE, angle="pca")).first.order == 1


def test_a_halved_shape_is_confirmed_on_its_mask():
    """Of order 2 for its contour, of which a notch is a small part, but not for what it covers."""
    assert look(ell(0.16, 0.05), 0.58, 0, 0).first.order == 1
    assert look(tee(0.16, 0.05), 0.58, 0, 0).first.order == 1


def test_a_round_object_has_no_angle_to_be_turned_by():
    first = look(disc(), 0.55, 0.0, 0)
    assert first.first.order == ROUND
    now = look(disc(), 0.6, 0.05, 77, first)
    assert now.theta == first.theta
    np.testing.assert_allclose(now.body, first.body, atol=3e-3)
