"""From pictures whose truth is known to contour, centroid, orientation and mask."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.cell.mask import MaskGrid
from deformpush.cell.perception import Perception, PerceptionError
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import matched_turn, principal_axis, resample, rotation, signed_area, wrap
from tests.pictures import RECT, centroid, lobed, picture, placed

CFG = compose(["object=meat", "contour.angle=pca"])
CAMERA = config.build(CFG.camera)
EYE: Perception = config.build(CFG.contour)
MEAT = config.build(CFG.object).polygon
SHAPES = {"rect": RECT, "meat": MEAT}
angles = st.floats(-np.pi, np.pi)


def look(*polygons, previous=None):
    return EYE.observe(picture(CAMERA, *polygons), CAMERA, previous)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(
    ("x", "y", "degrees"), [(0.58, 0.0, 0), (0.4007, -0.1513, 33), (0.7102, 0.1209, -70), (0.5, 0.2, 88)]
)
def test_area_centroid_and_outline(name, x, y, degrees):
    truth = placed(SHAPES[name], x, y, degrees)
    seen = look(truth)
    assert signed_area(seen.contour) == pytest.approx(signed_area(truth), rel=0.02)
    assert np.linalg.norm(seen.c - centroid(truth)) < 1e-3
    fine = resample(truth, 4000)
    off = np.linalg.norm(seen.contour[:, None] - fine, axis=2).min(axis=1)
    assert off.max() < 1.0 / CAMERA.scale, "a contour point more than a pixel off the outline"


@pytest.mark.parametrize("degrees", [-89, -45, -10, 0, 25, 60, 89])
def test_orientation_is_that_of_the_long_side(degrees):
    seen = look(placed(RECT, 0.55, 0.05, degrees))
    assert not seen.compact
    assert np.degrees(seen.theta) == pytest.approx(degrees, abs=0.5)


@pytest.mark.parametrize("degrees", [100, 180, 225])
def test_the_first_orientation_is_the_end_that_points_right(degrees):
    seen = look(placed(RECT, 0.55, 0.05, degrees))
    assert np.degrees(seen.theta) == pytest.approx(degrees - 180, abs=0.5)


@pytest.mark.parametrize("name", SHAPES)
def test_contour_is_even_and_counter_clockwise_from_theta(name):
    seen = look(placed(SHAPES[name], 0.6, 0.0, 40))
    assert len(seen.contour) == EYE.M
    assert signed_area(seen.contour) > 0
    gaps = np.linalg.norm(seen.contour - np.roll(seen.contour, -1, axis=0), axis=1)
    # Steps of the pixels give a tenth, a corner between two points shortens its gap to 1 / sqrt(2).
    assert 0.65 * np.median(gaps) < gaps.min() < gaps.max() < 1.1 * np.median(gaps)
    polar = wrap(np.arctan2(*(seen.contour - seen.c).T[::-1]) - seen.theta)
    assert np.argmin(np.abs(polar)) == 0


def test_two_blobs_the_larger_first_the_nearer_later():
    small, large = placed(0.4 * RECT, 0.4, 0.15, 0), placed(RECT, 0.65, -0.1, 0)
    assert look(small, large).c == pytest.approx([0.65, -0.1], abs=1e-3)
    before = look(placed(0.4 * RECT, 0.42, 0.14, 0))
    assert look(small, large, previous=before).c == pytest.approx([0.4, 0.15], abs=1e-3)


def test_specks_are_not_the_object():
    speck, obj = placed(0.1 * RECT, 0.58, 0.0, 0), placed(RECT, 0.58, 0.2, 0)
    before = look(placed(RECT, 0.58, 0.1, 0))
    assert look(speck, obj, previous=before).c == pytest.approx([0.58, 0.2], abs=1e-3)
    with pytest.raises(PerceptionError, match="no object in the picture"):
        look(speck)


def test_no_object():
    with pytest.raises(PerceptionError, match="no object in the picture"):
        look()
    with pytest.raises(PerceptionError, match="no object in the picture"):
        EYE.observe(picture(CAMERA, placed(RECT, 0.58, 0.0, 0), colour=(200, 60, 30)), CAMERA)


@pytest.mark.parametrize(("x", "y"), [(0.9, 0.0), (0.26, 0.0), (0.58, 0.32), (0.58, -0.32)])
def test_an_object_at_the_rim_is_not_measured(x, y):
    with pytest.raises(PerceptionError, match="left the picture"):
        look(placed(RECT, x, y, 0))


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("step", [20, -35])
def test_orientation_stays_continuous_through_180_degrees(name, step):
    seen = first = look(placed(SHAPES[name], 0.58, 0.0, 0))
    for turn in range(step, 14 * step, step):
        seen = look(placed(SHAPES[name], 0.58, 0.0, turn), previous=seen)
        assert np.degrees(seen.theta - first.theta) == pytest.approx(turn, abs=1.5)
    assert abs(seen.theta) > np.pi


def test_a_compact_shape_keeps_its_angle_by_matching_contours():
    shape = lobed(0.07, 0.08, 3)
    seen = first = look(placed(shape, 0.58, 0.0, 0))
    assert seen.compact
    for turn in range(12, 240, 12):
        seen = look(placed(shape, 0.58 + turn / 4000, 0.0, turn), previous=seen)
        assert seen.compact
        assert np.degrees(seen.theta - first.theta) == pytest.approx(turn, abs=4)


def test_an_axis_that_swaps_with_the_other_is_not_followed():
    """A rectangle squeezed until its longer side is the other one has not turned by 90 degrees."""
    seen = look(placed(RECT * (0.65, 1), 0.58, 0.0, 0))
    assert not seen.compact
    for ratio in (0.6, 0.55, 0.5, 0.45, 0.38):
        seen = look(placed(RECT * (ratio, 1), 0.58, 0.0, 0), previous=seen)
        assert np.degrees(seen.theta) == pytest.approx(0, abs=3)
    assert principal_axis(seen.contour - seen.c)[0] == pytest.approx(np.pi / 2, abs=0.05)
    assert seen.compact


def test_an_unmoved_object_does_not_turn():
    before = look(placed(lobed(0.07, 0.0, 1), 0.58, 0.0, 0))
    after = look(placed(lobed(0.07, 0.0, 1), 0.58, 0.0, 0), previous=before)
    assert after.theta == pytest.approx(before.theta, abs=1e-9)


def test_the_mask_does_not_depend_on_the_pose():
    straight = look(placed(MEAT, 0.58, 0.0, 0))
    turned = look(placed(MEAT, 0.45, 0.1, 50), previous=straight)
    differ = np.sum(straight.gamma ^ turned.gamma) / np.sum(straight.gamma)
    assert differ < 0.03
    assert np.sum(turned.gamma) * 1e-6 == pytest.approx(signed_area(MEAT), rel=0.02)


def test_mask_of_a_polygon_x_right_y_up():
    grid = MaskGrid(size=0.1, pixel=0.001)
    mask = grid.draw(np.array([(0.0, 0.0), (0.04, 0.0), (0.04, 0.02), (0.0, 0.02)]))
    rows, cols = np.nonzero(mask)
    assert mask.shape == (100, 100)
    assert mask.sum() == pytest.approx(800, rel=0.08)
    assert (cols.mean() - 49.5, 49.5 - rows.mean()) == pytest.approx((20, 10), abs=0.6)


@given(turn=st.floats(-np.pi / 3 + 0.02, np.pi / 3 - 0.02), shift=st.integers(0, 127))
def test_matched_turn_finds_the_turn_whatever_point_comes_first(turn, shift):
    before = resample(MEAT, 128)
    before -= before.mean(axis=0)
    after = np.roll(before @ rotation(turn).T, shift, axis=0)
    assert matched_turn(before, after) == pytest.approx(turn, abs=1e-9)


@given(angle=angles, ratio=st.floats(0.0, 0.98))
def test_principal_axis_of_an_ellipse(angle, ratio):
    t = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    points = np.column_stack([np.cos(t), ratio * np.sin(t)]) @ rotation(angle).T
    found, sigma = principal_axis(points)
    assert sigma == pytest.approx(ratio, abs=1e-6)
    assert np.sin(found - angle) == pytest.approx(0, abs=1e-6)


@given(angle=st.floats(-50, 50))
def test_wrap(angle):
    wrapped = float(wrap(angle))
    assert -np.pi <= wrapped < np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-9)


def test_resample_turns_clockwise_outlines_round():
    points = resample(RECT[::-1], 60)
    assert signed_area(points) == pytest.approx(0.02)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.01)
