"""The picture of a mesh: which pixels it covers, whatever lies behind, and the same bits every time."""

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.cell.camera import Camera
from deformpush.cell.rasteriser import draw
from deformpush.mechanics.mesh import slab
from tests import pictures

CAMERA = Camera(centre=(0.58, 0.0), field=0.7, distance=3.0, pixels=480)
NEAR = Camera(centre=(0.58, 0.0), field=0.7, distance=0.4, pixels=480)
BLUE = tuple(value / 255 for value in pictures.BLUE)
MESH = slab(pictures.RECT, 0.02, 0.02)
FACES = MESH.surface()


def standing(x: float, y: float, degrees: float, z: float = 0.0) -> np.ndarray:
    """Nodes of the slab there."""
    plan = pictures.placed(MESH.nodes[:, :2], x, y, degrees)
    return np.column_stack([plan, MESH.nodes[:, 2] + z])


def covered(picture: np.ndarray) -> np.ndarray:
    return (picture != 255).any(axis=2)


def from_rim(px: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance of points `(P, 2)` from the nearest side of a polygon."""
    sides = np.roll(corners, -1, axis=0) - corners
    relative = px[:, None] - corners
    share = np.clip((relative * sides).sum(axis=-1) / (sides**2).sum(axis=-1), 0, 1)
    return np.linalg.norm(relative - share[..., None] * sides, axis=-1).min(axis=1)


@given(x=st.floats(0.45, 0.7), y=st.floats(-0.1, 0.1), degrees=st.floats(0, 360))
def test_a_flat_sheet_is_the_polygon_of_its_rim(x, y, degrees):
    """A picture drawn pixel by pixel says the same, but for those whose middle lies on the rim."""
    drawn = draw(standing(x, y, degrees) * (1, 1, 0), FACES, CAMERA, BLUE)
    outline = pictures.placed(pictures.RECT, x, y, degrees)
    rows, columns = np.nonzero(np.any(drawn != pictures.picture(CAMERA, outline), axis=2))
    apart = np.column_stack([columns, rows]).astype(float)
    assert np.all(from_rim(apart, CAMERA.to_px(outline)) < 1 / 256)
    assert set(map(tuple, drawn[covered(drawn)])) == {pictures.BLUE}


def test_every_pixel_of_a_square_is_known():
    """Corners at pixels 10 and 14: five middles each way, the borders included."""
    px = np.array([(10, 10), (14, 10), (14, 14), (10, 14)], float)
    nodes = np.column_stack([CAMERA.to_m(px), np.zeros(4)])
    seen_from_below = np.array([[0, 1, 2], [0, 2, 3]])
    rows, columns = np.nonzero(covered(draw(nodes, seen_from_below, CAMERA, BLUE)))
    assert sorted(zip(rows, columns, strict=True)) == [(r, c) for r in range(10, 15) for c in range(10, 15)]
    assert not covered(draw(nodes, seen_from_below[:, ::-1], CAMERA, BLUE)).any(), "they face away"


def test_sides_are_seen_and_what_is_lower_is_larger():
    middle, aside = (covered(draw(standing(x, 0.0, 0), FACES, NEAR, BLUE)).sum() for x in (0.58, 0.78))
    assert aside > 1.02 * middle, "away from the optical axis the camera sees a side as well"
    low, high = (covered(draw(standing(0.58, 0, 0, z), FACES, NEAR, BLUE)).sum() for z in (0.0, 0.1))
    assert high / low == pytest.approx((0.4 / 0.5) ** 2, rel=0.02)


def test_neighbouring_triangles_leave_no_gap():
    for degrees in range(0, 90, 7):
        picture = covered(draw(standing(0.58, 0.0, degrees), FACES, CAMERA, BLUE))
        for row in picture[picture.any(axis=1)]:
            at = np.flatnonzero(row)
            assert len(at) == at[-1] - at[0] + 1, "a convex object has no holes"


@pytest.mark.parametrize("place", [(0.24, 0.0), (0.58, 0.34), (0.95, -0.36)])
def test_what_leaves_the_picture_is_cut_off(place):
    nodes = standing(*place, 20)
    wide = Camera(centre=CAMERA.centre, field=1.4, distance=3.0, pixels=960)
    whole = covered(draw(nodes, FACES, wide, BLUE))[240:720, 240:720]
    np.testing.assert_array_equal(covered(draw(nodes, FACES, CAMERA, BLUE)), whole)
    assert whole.any()


def test_an_object_out_of_sight_leaves_the_picture_white():
    for place in ((5.0, 0.0), (-5.0, 0.0), (0.58, 5.0), (0.58, -5.0)):
        assert not covered(draw(standing(*place, 0), FACES, CAMERA, BLUE)).any()


def test_the_picture_has_the_same_bits_everywhere():
    """Made once, kept here. Turned by 3-4-5, as sines may differ in their last bit."""
    nodes = MESH.nodes @ [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]] + [0.5, 0.05, 0.002]
    picture = draw(nodes, FACES, CAMERA, BLUE)
    assert hashlib.sha256(picture.tobytes()).hexdigest()[:16] == "b64c4279a03ddd89"
