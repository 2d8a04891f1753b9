"""Registration of contours over the whole circle: known turns come back, symmetries are found."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.cell.camera import Camera
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import principal_axis, resample, rotation, wrap
from deformpush.mechanics.registration import ROUND, Symmetry, register, symmetry
from tests import pictures
from tests.outlines import OUTLINES, disc, noisy, star

SHIPPED = ("dough", "fish_fillet", "meat", "pork", "rect", "tofu")
SHAPES = {name: config.build(compose([f"object={name}"]).object).polygon for name in SHIPPED} | OUTLINES
ORDERS = {
    **dict.fromkeys(SHAPES, 1),
    **dict.fromkeys(("dough", "meat", "pork", "rect", "tofu"), 2),
    "square": 4,
    "star": 5,
    "disc": ROUND,
}
"""Of meat and pork the two halves differ by less than a camera sees of most objects: 0.7 and 0.4 mm rms."""
PERCEPTION = config.build(compose([]).contour)
CAMERA: Camera = config.build(compose([]).camera)
NOISE = 5e-4


def error(angle, known, order):
    """Difference of angles (degrees), up to the turns that look alike."""
    step = 2 * np.pi / order
    return np.degrees((angle - known + step / 2) % step - step / 2)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def seen(outline, turn, shift, rng):
    """The contour as a camera sees it, 1.5 mm a pixel."""
    placed = (outline - outline.mean(axis=0)) @ rotation(turn).T + CAMERA.centre + shift
    return PERCEPTION.outline(pictures.picture(CAMERA, placed)[..., 0] < 128, CAMERA)


def with_noise(outline, turn, shift, rng):
    """Evenly spaced points, each 0.5 mm off."""
    return noisy(outline @ rotation(turn).T + shift, 128, NOISE, rng)


def errors(name, look, pairs):
    """Errors (degrees) of registration and of the principal axis for known turns over the whole circle."""
    rng, order = np.random.default_rng(0), ORDERS[name]
    registered, principal = [], []
    for _ in range(pairs):
        first, turn = rng.uniform(-np.pi, np.pi, 2)
        before = look(SHAPES[name], first, np.zeros(2), rng)
        after = look(SHAPES[name], first + turn, rng.uniform(-0.05, 0.05, 2), rng)
        registered.append(error(register(before, after).angle, turn, order))
        axes = [principal_axis(contour - contour.mean(axis=0))[0] for contour in (before, after)]
        principal.append(error(axes[1] - axes[0], turn, 2))
    return registered, principal


@pytest.mark.parametrize("name", [name for name, order in ORDERS.items() if order != ROUND])
def test_through_a_camera_it_is_at_least_twice_as_accurate_as_the_principal_axis(name):
    registered, principal = errors(name, seen, 15)
    assert rms(registered) < 0.2
    assert rms(registered) < 0.6 * rms(principal)
    assert np.abs(registered).max() < 0.5


@pytest.mark.parametrize(
    "name", ["dough", "fish_fillet", "meat", "pork", "rect", "tofu", "ell", "tee", "square"]
)
def test_with_noise_on_every_point_it_is_no_worse_than_the_principal_axis(name):
    registered, principal = errors(name, with_noise, 60)
    assert rms(registered) < 0.3
    assert rms(registered) < 1.05 * rms(principal)


def test_a_tee_within_0_6_degrees():
    assert rms(errors("tee", with_noise, 60)[0]) < 0.6


@pytest.mark.parametrize("look", [seen, with_noise])
@pytest.mark.parametrize("name", SHAPES)
def test_the_order_of_symmetry_is_found_at_any_angle(name, look):
    rng = np.random.default_rng(1)
    for _ in range(5):
        found = symmetry(look(SHAPES[name], rng.uniform(-np.pi, np.pi), np.zeros(2), rng))
        assert found.order == ORDERS[name]
        assert 0 < found.confidence <= 1


@pytest.mark.parametrize("corners", [3, 4, 5, 6, 7, 8])
def test_regular_polygons_have_as_many_turns_as_corners(corners):
    assert symmetry(disc(0.07, corners)).order == corners
    assert symmetry(star(corners)).order == corners


def test_the_confidence_falls_towards_the_threshold():
    """A disc with two lobes: less and less an oval, at last a disc."""
    orders, confidences = [], []
    for depth in (0.2, 0.1, 0.05, 0.025, 0.012, 0.006, 0.0):
        found = symmetry(pictures.lobed(0.08, depth, 2))
        orders.append(found.order)
        confidences.append(found.confidence)
    change = orders.index(ROUND)
    assert orders == [2] * change + [ROUND] * (7 - change)
    assert 0 < change < 6
    assert confidences[:change] == sorted(confidences[:change], reverse=True)
    assert confidences[change:] == sorted(confidences[change:])
    assert min(confidences) < 0.5
    assert confidences[-1] == pytest.approx(1, abs=1e-3)


@settings(max_examples=40)
@given(
    name=st.sampled_from([name for name, order in ORDERS.items() if order != ROUND]),
    turn=st.floats(-np.pi, np.pi),
    x=st.floats(-0.3, 0.3),
    first=st.integers(0, 127),
)
def test_a_rigid_motion_comes_back(name, turn, x, first):
    """No matter where the contour begins: angle near the true one, shift of the mean, next to no residual."""
    was = resample(SHAPES[name], 128)
    now = np.roll(was @ rotation(turn).T + (x, -x), first, axis=0)
    found = register(was, now, near=turn + 0.1)
    assert found.angle == pytest.approx(turn, abs=np.radians(0.1))
    middle = resample(was, 128).mean(axis=0)
    np.testing.assert_allclose(found.shift, rotation(turn) @ middle + (x, -x) - middle, atol=1e-4)
    assert found.residual < 2e-4


def test_of_turns_that_look_alike_the_least_or_the_one_asked_for_is_told():
    rect = resample(SHAPES["rect"], 128)
    half = rect @ rotation(np.pi + 0.2).T
    assert register(rect, half).angle == pytest.approx(0.2, abs=1e-3)
    assert register(rect, half, near=3.0).angle == pytest.approx(np.pi + 0.2, abs=1e-3)
    assert register(rect, half, near=-3.0).angle == pytest.approx(0.2 - np.pi, abs=1e-3)
    assert register(rect, half, near=20.0).angle == pytest.approx(0.2 + 6 * np.pi, abs=1e-3)


def test_a_rectangle_turned_by_180_degrees_lies_as_before():
    rect = resample(SHAPES["rect"], 128)
    assert symmetry(rect).order == 2
    assert register(rect, rect @ rotation(np.pi).T).angle == pytest.approx(0, abs=1e-6)


def test_an_l_turned_by_180_degrees_does_not():
    tee = resample(SHAPES["tee"], 128)
    found = register(tee, tee @ rotation(np.pi).T)
    assert abs(found.angle) == pytest.approx(np.pi, abs=1e-3)
    assert found.residual < 1e-4


def test_a_round_contour_has_no_angle_but_a_place():
    rng = np.random.default_rng(0)
    was, now = (noisy(disc() + shift, 128, NOISE, rng) for shift in ((0.1, 0.2), (0.13, 0.19)))
    found = register(was, now)
    assert found.angle is None
    np.testing.assert_allclose(found.shift, (0.03, -0.01), atol=3e-4)
    assert found.residual < 1e-3


def test_what_looks_alike_repeats_after_the_symmetry_s_step():
    assert Symmetry(4, 1.0).nearest(0.1, 1.5) == pytest.approx(0.1 + np.pi / 2)
    assert Symmetry(1, 1.0).nearest(0.1, 3.0) == pytest.approx(0.1)
    assert Symmetry(1, 1.0).nearest(0.1, 3.5) == pytest.approx(0.1 + 2 * np.pi)
    assert Symmetry(ROUND, 1.0).nearest(0.1, 1.5) == 1.5


def test_the_residual_is_what_a_rigid_motion_cannot_explain():
    """A dent 5 mm deep, some 20 mm wide."""
    fine = resample(SHAPES["rect"], 512)
    dented = fine + np.column_stack(
        [np.zeros(512), 0.005 * (fine[:, 1] < 0) * np.exp(-0.5 * (fine[:, 0] / 0.01) ** 2)]
    )
    found = register(fine, dented @ rotation(2.0).T, near=2.0)
    assert found.angle == pytest.approx(2.0, abs=np.radians(0.5))
    assert 3e-4 < found.residual < 1.5e-3


def test_the_shift_is_that_of_what_moved_rigidly():
    """A flap unfolds: the mean of the points moves by 15 mm, the object does not."""
    was = np.array([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)])
    flap = [(0.1, -0.01), (0.14, -0.01), (0.14, 0.01), (0.1, 0.01)]
    now = np.array([*was[:2], *flap, *was[2:]])
    moved = resample(now, 128).mean(axis=0) - resample(was, 128).mean(axis=0)
    assert np.linalg.norm(moved) > 0.015
    found = register(was, now, near=0.0)
    assert np.linalg.norm(found.shift) < 0.7 * np.linalg.norm(moved)


def test_turning_there_and_back_cancels():
    rng = np.random.default_rng(2)
    for name in ("tee", "ell", "fish"):
        was = noisy(SHAPES[name], 128, NOISE, rng)
        now = noisy(SHAPES[name] @ rotation(2.5).T, 128, NOISE, rng)
        assert float(wrap(register(was, now).angle + register(now, was).angle)) == pytest.approx(0, abs=2e-3)
