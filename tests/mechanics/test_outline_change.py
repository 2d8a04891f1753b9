"""What two contours say of a deformation: nothing of a rigid motion, the truth where it is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.mechanics.geometry import resample, rotation, signed_area
from deformpush.mechanics.outline_change import SMOOTH, contour_change, curvature, nearest, rigid_fit
from tests import pictures

SHAPES = {
    "rect": pictures.RECT,
    "lobed": pictures.lobed(0.08, 0.1, 3),
    "ellipse": np.array([0.1, 0.05]) * pictures.lobed(1.0, 0.0, 2),
}
turns = st.floats(-np.pi / 3.2, np.pi / 3.2)


def dented(shape: np.ndarray, depth: float) -> np.ndarray:
    """The contour pressed in by `depth` (m) from below, over some 20 mm."""
    fine = resample(shape, 512)
    under = (fine[:, 1] < 0) * np.exp(-0.5 * (fine[:, 0] / 0.01) ** 2)
    return fine + np.column_stack([np.zeros(512), depth * under])


@pytest.mark.parametrize("name", SHAPES)
@settings(max_examples=20)
@given(turn=turns, x=st.floats(-0.5, 0.5), first=st.integers(0, 127))
def test_a_rigid_motion_changes_nothing(name, turn, x, first):
    contour = resample(SHAPES[name], 128)
    moved = np.roll(contour @ rotation(turn).T + (x, -x), first, axis=0)
    change = contour_change(contour, moved)
    assert abs(change.area) < 2e-3
    assert abs(change.length) < 4e-3, "points that lie beside a corner cut it off"
    assert change.residual < 2e-3
    assert change.dent < 5e-3


@pytest.mark.parametrize("name", ["lobed", "ellipse"])
@pytest.mark.parametrize("factor", [0.95, 1.02, 1.1])
def test_growing_is_seen_in_area_length_and_residual(name, factor):
    contour = resample(SHAPES[name], 256)
    change = contour_change(contour, factor * contour)
    assert change.area == pytest.approx(factor**2 - 1, abs=1e-9)
    assert change.length == pytest.approx(factor - 1, abs=1e-9)
    assert 0 < change.residual < change.dent


def test_a_circle_that_grows_is_everywhere_as_far_away():
    angle = np.linspace(0, 2 * np.pi, 256, endpoint=False)
    circle = 0.05 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    change = contour_change(circle, 1.04 * circle)
    over = 0.002 / np.sqrt(np.pi * 0.05**2)
    assert change.residual == pytest.approx(over, rel=2e-3)
    assert change.dent == pytest.approx(over, rel=2e-3)
    shrunk = np.exp((2 * np.pi * SMOOTH) ** 2 / 2)  # smoothing draws a circle together
    np.testing.assert_allclose(curvature(circle), 20.0 * shrunk, rtol=1e-9)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_the_deeper_a_dent_the_larger_every_measure_of_shape(name, turn):
    shape = resample(SHAPES[name], 256)
    changes = [
        contour_change(shape, dented(SHAPES[name], depth) @ rotation(turn).T + 0.1)
        for depth in (0.0, 0.001, 0.003, 0.006)
    ]
    for measure in ("residual", "dent", "curvature"):
        values = [getattr(change, measure) for change in changes]
        assert values == sorted(values)
        assert values[-1] > 2 * values[0]
    depth = changes[-1].dent * np.sqrt(signed_area(shape))
    assert 0.004 < depth < 0.0065, "the depth of the dent, but for what the fit takes of it"
    assert changes[-1].area < 0


def test_nearest_places_on_a_square():
    square = np.array([(0.0, 0), (1, 0), (1, 1), (0, 1)])
    points = np.array([(0.5, -0.3), (1.4, 0.5), (1.2, 1.3), (0.4, 0.45)])
    np.testing.assert_allclose(nearest(points, square), [(0.5, 0), (1, 0.5), (1, 1), (0, 0.45)])


@settings(max_examples=20)
@given(turn=turns)
def test_the_fit_lays_a_turned_contour_back(turn):
    shape = resample(SHAPES["lobed"], 128)
    apart, shift = rigid_fit(shape, np.roll(shape @ rotation(turn).T + 0.3, 40, axis=0))
    assert apart.max() < 1e-6
    assert shift == 40
