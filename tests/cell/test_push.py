"""Effective and augmented contour, and the tool's path around an object."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.cell.effective import EffectiveContour
from deformpush.cell.observation import Observation
from deformpush.cell.push import Push, touch
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import resample, rotation, signed_area, wrap
from tests.pictures import RECT

CLOSED = EffectiveContour(90.0, 450.0)
OPEN = EffectiveContour(180.0, 360.0)
MEAT = config.build(compose(["object=meat"]).object).polygon
L_SHAPE = np.array([(-0.08, -0.08), (0.1, -0.08), (0.1, -0.02), (-0.02, -0.02), (-0.02, 0.1), (-0.08, 0.1)])
SHAPES = {"rect": RECT, "meat": MEAT, "L": L_SHAPE}
kappas = st.floats(0, 1)


def push(augment="radial", **changed):
    values = {"offset": 0.02, "tool_radius": 0.01, "contact_margin": 0.002, "clearance": 0.004, **changed}
    return Push(augment=augment, **values)


def observed(shape=RECT, theta=0.0, c=(0.5, 0.1), roll=0):
    contour = np.roll(resample(shape, 128), roll, axis=0)
    contour = (contour - contour.mean(axis=0)) @ rotation(theta).T + c
    return Observation(contour, np.array(c), theta, np.ones((2, 2), bool), False)


def distance(point, contour):
    return np.linalg.norm(contour - point, axis=1).min()


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_the_augmented_contour_is_equation_5(shape):
    seen = observed(shape, theta=0.4)
    for v, v_s in zip(seen.contour, push().augmented(seen.contour, seen.c), strict=True):
        v_b = v - seen.c
        np.testing.assert_allclose(v_s, v + 0.02 * v_b / np.sqrt(v_b @ v_b), atol=1e-12)


def test_along_the_normal_every_side_moves_out_by_the_offset():
    seen = observed()
    body = push("normal").augmented(seen.contour, seen.c) - seen.c
    outline = seen.contour - seen.c
    long_side = np.abs(outline[:, 0]) < 0.07  # away from the corners by more than the tool's width
    np.testing.assert_allclose(np.abs(body[long_side, 1]), 0.05 + 0.02, atol=1e-9)
    np.testing.assert_allclose(body[long_side, 0], outline[long_side, 0], atol=1e-9)
    short_side = np.abs(outline[:, 1]) < 0.02
    np.testing.assert_allclose(np.abs(body[short_side, 0]), 0.1 + 0.02, atol=1e-9)
    assert np.linalg.norm(body - outline, axis=1) == pytest.approx(0.02)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_normals_point_inward_and_have_length_1(shape):
    seen = observed(shape)
    inward = push().inward(seen.contour)
    assert np.linalg.norm(inward, axis=1) == pytest.approx(1)
    assert signed_area(seen.contour + 0.001 * inward) < signed_area(seen.contour)
    assert signed_area(seen.contour - 0.001 * inward) > signed_area(seen.contour)


@pytest.mark.parametrize("theta", [0.0, 2.5, -7.0])
@pytest.mark.parametrize("roll", [0, 50])
def test_a_closed_effective_contour_goes_round_once_from_its_seam(theta, roll):
    seen = observed(theta=theta, roll=roll)
    index = CLOSED.indices(seen)
    assert CLOSED.closed
    assert len(index) == 129
    assert index[0] == index[-1]
    assert sorted(index[:-1]) == list(range(128))
    np.testing.assert_array_equal(np.diff(index) % 128, 1)  # counter-clockwise
    polar = np.arctan2(*(seen.contour[index[0]] - seen.c)[::-1]) - theta
    assert float(wrap(polar - np.pi / 2)) == pytest.approx(0, abs=0.06)


@pytest.mark.parametrize("theta", [0.0, 2.5, -7.0])
@pytest.mark.parametrize(("first", "last"), [(180.0, 360.0), (-40.0, 60.0), (100.0, 370.0)])
def test_an_open_effective_contour_runs_between_its_directions(theta, first, last):
    seen = observed(theta=theta, roll=17)
    part = EffectiveContour(first, last)
    index = part.indices(seen)
    assert not part.closed
    assert len(set(index)) == len(index)
    polar = np.unwrap(np.arctan2(*(seen.contour[index] - seen.c).T[::-1]) - theta)
    swept = np.degrees(polar - polar[0])
    assert np.all(np.diff(swept) > 0)
    assert swept[-1] == pytest.approx(
        last - first, abs=5
    )  # two points under the centroid are up to 6 degrees apart
    assert np.degrees(float(wrap(polar[0] - np.radians(first)))) == pytest.approx(0, abs=3)


@pytest.mark.parametrize(("first", "last"), [(90, 90), (90, 451), (90, 0)])
def test_directions_of_the_effective_contour_are_checked(first, last):
    with pytest.raises(
        ValueError, match=r"^last_deg: .* must lie in \(first_deg, first_deg \+ 360\] = \(90, 450\]"
    ):
        EffectiveContour(first, last)


def test_the_tool_must_start_outside_the_contour():
    with pytest.raises(ValueError, match=r"^offset: 0\.01 must be larger than tool_radius 0.01"):
        push(offset=0.01)


@pytest.mark.parametrize("part", [CLOSED, OPEN], ids=["closed", "open"])
@pytest.mark.parametrize("augment", ["radial", "normal"])
@settings(max_examples=40)
@given(kappa=kappas)
def test_kappa_is_a_share_of_the_arc_length_of_the_effective_contour(part, augment, kappa):
    seen, plan = observed(MEAT, theta=0.3), push(augment)
    effective = plan.effective(seen, part).points
    path = plan.plan(np.array([kappa, 0.02]), seen, part)
    steps = np.linalg.norm(np.diff(effective, axis=0), axis=1)
    left, i = kappa * steps.sum(), 0
    while i < len(steps) - 1 and left > steps[i]:
        left, i = left - steps[i], i + 1
    at = effective[i] + left / steps[i] * (effective[i + 1] - effective[i])
    along = (at - path.start) @ path.direction
    np.testing.assert_allclose(path.start + along * path.direction, at, atol=1e-9)
    assert along >= -1e-12, "a start is moved back, never forward"


def test_both_ends_of_a_closed_contour_are_the_same_push():
    seen = observed(MEAT)
    first, last = (push().plan(np.array([kappa, 0.02]), seen, CLOSED) for kappa in (0.0, 1.0))
    np.testing.assert_allclose(first.start, last.start, atol=1e-12)
    np.testing.assert_allclose(first.direction, last.direction, atol=1e-12)


@pytest.mark.parametrize(
    ("kappa", "direction"), [(0.0, (0, -1)), (0.25, (1, 0)), (0.5, (0, 1)), (0.75, (-1, 0)), (1.0, (0, -1))]
)
@pytest.mark.parametrize("theta", [0.0, 1.1])
def test_a_push_is_perpendicular_to_the_side_it_meets(kappa, direction, theta):
    square = RECT * (0.5, 1)
    path = push().plan(np.array([kappa, 0.02]), observed(square, theta=theta), CLOSED)
    np.testing.assert_allclose(path.direction, rotation(theta) @ direction, atol=0.02)


@pytest.mark.parametrize("augment", ["radial", "normal"])
@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
@settings(max_examples=40)
@given(kappa=kappas, d=st.floats(0.005, 0.05))
def test_the_tool_starts_clear_and_d_counts_from_the_touch(shape, augment, kappa, d):
    seen, plan = observed(shape, theta=-0.8), push(augment)
    path = plan.plan(np.array([kappa, d]), seen, CLOSED)
    assert np.linalg.norm(path.direction) == pytest.approx(1)
    assert path.approach >= plan.clearance - 1e-12
    np.testing.assert_allclose(path.end - path.contact, d * path.direction, atol=1e-12)
    on_the_way = np.linspace(path.start, path.contact, 30)
    assert min(distance(p, seen.contour) for p in on_the_way) >= plan.reach - 1e-9
    missed = touch(path.start, path.direction, seen.contour, plan.reach) is None
    assert missed or distance(path.contact, seen.contour) == pytest.approx(plan.reach, abs=1e-9)


def test_a_line_past_the_object_is_pushed_from_where_it_passes_the_contour():
    """A thin tip seen under a grazing normal: no contour point lies within reach of the line."""
    seen = observed(L_SHAPE)
    plan = push(tool_radius=0.0005, contact_margin=0.0)
    paths = [plan.plan(np.array([k, 0.02]), seen, CLOSED) for k in np.linspace(0, 1, 400)]
    missing = [p for p in paths if touch(p.start, p.direction, seen.contour, plan.reach) is None]
    assert missing
    for path in missing:
        assert distance(path.contact, seen.contour) < plan.offset, "beside the object, not before it"
        assert path.approach >= plan.clearance - 1e-12


@given(
    x=st.floats(-0.3, 0.3),
    y=st.floats(-0.3, 0.3),
    angle=st.floats(-np.pi, np.pi),
    reach=st.floats(0.005, 0.03),
)
def test_touch_against_a_disc_that_is_carried_along(x, y, angle, reach):
    contour = resample(L_SHAPE, 64)
    start, direction = np.array([x, y]), np.array([np.cos(angle), np.sin(angle)])
    travel = touch(start, direction, contour, reach)
    way = np.linspace(-1, 1, 801)
    line = start + way[:, None] * direction
    gap = np.linalg.norm(contour[None] - line[:, None], axis=2).min(axis=1)
    if travel is None:
        assert gap.min() >= reach - 1e-9
        return
    assert distance(start + travel * direction, contour) == pytest.approx(reach, abs=1e-9)
    assert gap[way < travel].min() >= reach - 1e-9


def test_touch_head_on_past_and_from_inside():
    contour = np.array([[0.1, 0.0], [0.1, 0.02]])
    east = np.array([1.0, 0.0])
    assert touch(np.zeros(2), east, contour, 0.01) == pytest.approx(0.09)
    assert touch(np.array([0.0, 0.026]), east, contour, 0.01) == pytest.approx(0.1 - 0.008)
    assert touch(np.array([0.0, 0.0301]), east, contour, 0.01) is None
    assert touch(np.array([0.095, 0.0]), east, contour, 0.01) == pytest.approx(-0.005)
