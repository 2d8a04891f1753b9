"""Lines become one polygon of few points, and those keep its area."""

import numpy as np
import pytest
import shapely

from deformpush.outlines.clean import MOST_POINTS, largest_piece, longer_side, simplified
from deformpush.outlines.thin import without_noise, without_thin
from tests.outlines import OUTLINES, disc, star

SQUARE = np.array([(0, 0), (100, 0), (100, 100), (0, 100)], float)


@pytest.mark.parametrize("tolerance", [1e-4, 4e-4, 1e-3])
def test_fewer_points_keep_the_area_of_what_is_round(tolerance):
    """Chords alone cut 0.2, 0.8 and 2.1 % off."""
    whole = shapely.Polygon(disc(0.07, 2000))
    fewer, off = simplified(whole, tolerance)
    assert fewer.area == pytest.approx(whole.area, rel=2e-3)
    assert off < 1.5 * tolerance
    assert len(fewer.exterior.coords) < 2.5 * np.sqrt(0.07 / tolerance) + 20


def test_an_outline_as_rough_as_can_be_has_no_more_points_than_are_allowed():
    rng = np.random.default_rng(0)
    angle = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    r = 0.07 + rng.uniform(0, 0.001, 2000)
    fewer, _ = simplified(shapely.Polygon(np.column_stack([r * np.cos(angle), r * np.sin(angle)])), 1e-5)
    assert len(fewer.exterior.coords) <= MOST_POINTS + 10


def test_the_largest_piece_is_taken_and_its_hole_filled():
    found = largest_piece([SQUARE, SQUARE * 0.3 + 20, SQUARE * 0.5 + 200])
    assert found.polygon.area == pytest.approx(100 * 100)
    assert [note.split(":")[0] for note in found.notes] == ["pieces", "holes"]
    assert "cover 25.0% of its area" in found.notes[0]
    assert "1 filled, 9.0% of its area" in found.notes[1]


def test_parts_that_overlap_are_one():
    found = largest_piece([SQUARE, SQUARE + np.array([90, 0])])
    assert found.polygon.area == pytest.approx(190 * 100)
    assert found.notes == ()


def test_the_longer_side_of_what_is_turned():
    turned = shapely.affinity.rotate(shapely.Polygon(SQUARE * (2, 1)), 30)
    assert longer_side(turned) == pytest.approx(200)


@pytest.mark.parametrize("name", OUTLINES)
def test_corners_stay_where_thin_parts_are_cut_off(name):
    whole = shapely.Polygon(OUTLINES[name])
    left = without_thin(whole, 0.006)
    assert left.area == pytest.approx(whole.area, rel=0.01)


def test_a_whisker_goes_and_a_tip_stays():
    tips = shapely.Polygon(star())
    whisker = shapely.box(0, 0, 0.12, 0.0008)
    clean = without_noise(shapely.union(tips, whisker), 0.0016, 0.002)
    assert clean.bounds == pytest.approx(tips.bounds, abs=1.5e-3)
    assert clean.area == pytest.approx(tips.area, rel=2e-3)
