"""Pixels and metres."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.cell.camera import Camera

CAMERA = Camera(centre=(0.58, 0.1), field=0.7, distance=3.0, pixels=480, plane_z=0.012)
metres = st.floats(-2, 2)


@given(x=metres, y=metres)
def test_pixels_and_back(x, y):
    np.testing.assert_allclose(CAMERA.to_m(CAMERA.to_px([x, y])), [x, y], atol=1e-12)


def test_the_picture_reads_like_a_map():
    middle, right, up = CAMERA.to_px([[0.58, 0.1], [0.68, 0.1], [0.58, 0.2]])
    np.testing.assert_allclose(middle, [239.5, 239.5])
    assert (right[0] > middle[0], right[1]) == (True, middle[1])
    assert (up[1] < middle[1], up[0]) == (True, middle[0])


@pytest.mark.parametrize("z", [0.0, 0.012, 0.3])
def test_scale_follows_the_rays_through_the_pinhole(z):
    camera = Camera(centre=(0.0, 0.0), field=0.7, distance=3.0, pixels=480, plane_z=z)
    rim_on_table = np.array([0.35, 0.0, 0.0])
    lens = np.array([0.0, 0.0, -3.0])
    rim = lens + (rim_on_table - lens) * (3.0 + z) / 3.0  # where the same ray crosses the plane z
    np.testing.assert_allclose(camera.to_px(rim[:2])[0], 479.5)


def test_sees_all_points_or_not():
    half = 239.5 / CAMERA.scale
    rim = np.array([[0.58 + half, 0.1], [0.58, 0.1 - half]])
    assert CAMERA.sees(rim * (1 - 1e-9) + 1e-9 * np.array(CAMERA.centre))
    assert not CAMERA.sees(rim, border_px=1.0)
    assert not CAMERA.sees([[0.58, 0.1], [0.58 + 1.01 * half, 0.1]])
    assert not CAMERA.sees([0.58, 0.1 + 1.01 * half])


@pytest.mark.parametrize("z", [-0.1, 0.0, 0.012, 0.3])
def test_points_at_any_height_are_projected_through_the_pinhole(z):
    """Where the ray from the lens through the point meets the measuring plane."""
    point = np.array([0.7, -0.05, z])
    lens = np.array([*CAMERA.centre, -CAMERA.distance])
    on_plane = lens + (point - lens) * (CAMERA.distance + CAMERA.plane_z) / (CAMERA.distance + z)
    np.testing.assert_allclose(CAMERA.project(point), CAMERA.to_px(on_plane[:2]), atol=1e-9)


def test_what_lies_on_the_measuring_plane_is_where_it_is_measured():
    points = np.array([[[0.5, 0.1], [0.6, -0.2]]])
    on_plane = np.concatenate([points, np.full((1, 2, 1), CAMERA.plane_z)], axis=-1)
    np.testing.assert_array_equal(CAMERA.project(on_plane), CAMERA.to_px(points))
