"""Plane meshes: every outline is filled, without gaps or overlaps, by triangles that are not flat."""

from collections import Counter
from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.mechanics.geometry import resample, rotation, signed_area
from deformpush.mechanics.outline import contains, simple
from deformpush.mechanics.outline_change import nearest
from deformpush.mechanics.triangulation import MAX_CELLS, PlaneMesh, triangulate
from tests.outlines import OUTLINES, RANDOM, comb, disc, ell, noisy, rectangle


def angles(mesh: PlaneMesh) -> np.ndarray:
    """Angles (degrees) `(T, 3)`, by the law of cosines."""
    corners = mesh.points[mesh.triangles]
    a, b, c = (np.linalg.norm(corners[:, k] - corners[:, k - 1], axis=1) for k in range(3))
    sides = [(a, b, c), (b, c, a), (c, a, b)]
    return np.degrees(np.stack([np.arccos((p**2 + q**2 - r**2) / (2 * p * q)) for p, q, r in sides], axis=1))


def assert_fills(mesh: PlaneMesh) -> None:
    """The triangles fill the rim: edges belong to two, those of the rim to one; no area is there twice."""
    sides = Counter((a, b) for t in mesh.triangles.tolist() for a, b in zip(t, t[1:] + t[:1], strict=True))
    assert set(sides.values()) == {1}
    alone = {(a, b) for a, b in sides if (b, a) not in sides}
    assert alone == {(k, (k + 1) % mesh.rim) for k in range(mesh.rim)}
    assert mesh.areas.min() > 0
    assert mesh.areas.sum() == pytest.approx(signed_area(mesh.points[: mesh.rim]), rel=1e-9)
    assert len(np.unique(mesh.triangles)) == len(mesh.points)
    assert contains(mesh.points[: mesh.rim], mesh.points[mesh.rim :]).all()


@pytest.mark.parametrize("cell", [0.008, 0.0133, 0.02])
@pytest.mark.parametrize("name", OUTLINES)
def test_an_outline_is_filled_by_good_triangles_of_the_wanted_size(name, cell):
    outline = OUTLINES[name]
    mesh = triangulate(outline, cell)
    assert_fills(mesh)
    found = angles(mesh)
    assert found.min() > 25
    assert found.max() < 120
    assert mesh.areas.sum() == pytest.approx(signed_area(outline), rel=6e-3)
    # Arms one to two cells wide hold no points inside: there the triangles are larger.
    assert 0.7 < np.median(mesh.areas) / (np.sqrt(3) / 4 * cell**2) < 1.8
    away = mesh.points[: mesh.rim] - nearest(mesh.points[: mesh.rim], outline)
    assert np.linalg.norm(away, axis=1).max() < 0.08 * cell


@pytest.mark.parametrize("name", ["rect", "square", "ell", "thin ell", "tee", "star"])
def test_corners_are_kept(name):
    mesh = triangulate(OUTLINES[name], 0.0133)
    gaps = np.linalg.norm(mesh.points[: mesh.rim, None] - OUTLINES[name], axis=2).min(axis=0)
    assert gaps.max() < 1e-12
    assert mesh.areas.sum() == pytest.approx(signed_area(OUTLINES[name]), rel=1e-12)


def test_a_disc_keeps_its_area_though_its_sides_are_straight():
    """Eleven points on it alone would cut off 5 %."""
    mesh = triangulate(disc(0.07), 0.04)
    assert mesh.rim == 11
    assert mesh.areas.sum() == pytest.approx(np.pi * 0.07**2, rel=3e-3)


@pytest.mark.parametrize("name", OUTLINES)
def test_the_mesh_is_the_same_to_the_bit(name):
    first, second = (triangulate(OUTLINES[name].copy(), 0.0133) for _ in range(2))
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.triangles, second.triangles)


def test_a_clockwise_outline_makes_the_same_mesh():
    first, second = triangulate(ell(), 0.0133), triangulate(ell()[::-1], 0.0133)
    np.testing.assert_array_equal(first.points, second.points)


@pytest.mark.parametrize("name", ["ell", "kidney", "fish"])
def test_a_turned_outline_makes_a_mesh_as_good(name):
    """The lattice lies along the principal axes."""
    straight = triangulate(OUTLINES[name], 0.0133)
    turned = triangulate(OUTLINES[name] @ rotation(0.6).T + 0.3, 0.0133)
    back = (turned.points - 0.3) @ rotation(0.6)
    assert len(back) == len(straight.points)
    np.testing.assert_allclose(back, straight.points, atol=1e-9)


@pytest.mark.parametrize("name", ["fish", "ell", "kidney", "disc"])
def test_a_contour_that_a_camera_sees_takes_less_than_20_ms(name):
    rng = np.random.default_rng(0)
    contours = [noisy(OUTLINES[name], 128, 0.0003, rng) for _ in range(20)]
    sizes, seconds = [], []
    for contour in contours:
        cell = np.sqrt(signed_area(contour) / 45)
        began = process_time()
        mesh = triangulate(contour, cell)
        seconds.append(process_time() - began)
        sizes.append(len(mesh.points))
        assert_fills(mesh)
        assert angles(mesh).min() > 15
    assert 50 < np.median(sizes) < 80
    assert np.median(seconds) < 0.02


@pytest.mark.parametrize("kind", ["comb", "spiral"])
def test_gaps_far_narrower_than_a_cell_are_meshed_around(kind):
    """The rim is halved there until no triangle lies across."""
    for seed in range(20):
        assert_fills(triangulate(RANDOM[kind](np.random.default_rng(seed)), 0.02))


def test_relaxing_makes_the_smallest_angles_larger(monkeypatch):
    def smallest():
        cells = np.linspace(0.007, 0.02, 5)
        return np.mean([angles(triangulate(o, c)).min() for o in OUTLINES.values() for c in cells])

    relaxed = smallest()
    monkeypatch.setattr("deformpush.mechanics.triangulation._ROUNDS", 0)
    assert relaxed > smallest() + 0.3
    assert relaxed > 32


def test_parts_that_come_near_each_other_are_kept_apart():
    """A slit a fortieth of a cell wide."""
    slit = np.array([(0, 0), (0.1, 0), (0.1, 0.1), (0.0505, 0.1), (0.0503, 0.06), (0.05, 0.1), (0, 0.1)])
    mesh = triangulate(slit, 0.02)
    assert_fills(mesh)
    assert mesh.areas.sum() == pytest.approx(signed_area(slit), rel=1e-3)


def test_parts_that_come_too_near_are_refused():
    right = [(0, 0), (0.1, 0), (0.1, 0.1), (0.05001, 0.1), (0.05001, 0.03)]
    slit = np.array([*right, (0.05, 0.03), (0.05, 0.1), (0, 0.1)])
    with pytest.raises(
        ValueError, match=r"^cell: 0.02 m is too large where two parts of the outline come within"
    ):
        triangulate(slit, 0.02)


@settings(max_examples=200)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(sorted(RANDOM)), cell=st.floats(0.004, 0.03))
def test_whatever_the_outline_it_is_filled_or_refused_in_bounded_time(seed, kind, cell):
    outline = RANDOM[kind](np.random.default_rng(seed))
    began, refused = process_time(), ""
    try:
        mesh = triangulate(outline, cell)
    except ValueError as reason:
        refused = str(reason)
    assert process_time() - began < 3.0
    if refused:
        assert refused.startswith(("outline: ", "cell: "))
    else:
        assert_fills(mesh)


def test_a_mesh_too_large_is_refused_before_it_is_built():
    began = process_time()
    with pytest.raises(ValueError, match=f"^cell: 0.0002 m makes some .* cells, {MAX_CELLS} are allowed"):
        triangulate(rectangle(), 2e-4)
    assert process_time() - began < 0.1


def test_an_outline_that_meets_itself_is_refused():
    with pytest.raises(ValueError, match=r"^outline: crosses or touches itself"):
        triangulate(rectangle()[[0, 2, 1, 3]], 0.02)


def test_an_outline_that_was_checked_is_not_checked_again(monkeypatch):
    plan = simple(comb(np.random.default_rng(3)))
    monkeypatch.setattr("deformpush.mechanics.triangulation.simple", None)
    assert_fills(triangulate(plan, 0.01))


def test_fine_points_along_a_smooth_outline_are_no_corners():
    few, many = (triangulate(resample(OUTLINES["kidney"], n), 0.0133) for n in (128, 1024))
    assert abs(few.rim - many.rim) <= 1
