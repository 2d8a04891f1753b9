"""Which points of a contour a straight push can reach."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.cell.effective import EffectiveContour
from deformpush.cell.observation import Observation
from deformpush.cell.push import Push
from deformpush.cell.pushable import pushable
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import resample, rotation
from tests.outlines import OUTLINES, ell, rectangle, ring

REACH = 0.012
SHIPPED = ("dough", "fish_fillet", "meat", "pork", "rect", "silicone", "tofu")
SHAPES = {name: config.build(compose([f"object={name}"]).object).polygon for name in SHIPPED} | OUTLINES
ROUND = EffectiveContour(90.0, 450.0)


def push(augment="normal", tool_radius=0.01):
    return Push(0.02, augment, tool_radius, contact_margin=0.002, clearance=0.004)


def observed(shape, points=128, turn=0.0):
    contour = resample(shape, points) @ rotation(turn).T
    return Observation(contour, contour.mean(axis=0), turn, np.ones((2, 2), bool), False)


def straight(contour):
    """Pushes of each point along its own normal."""
    seen = Observation(contour, contour.mean(axis=0), 0.0, np.ones((2, 2), bool), False)
    return contour, push().inward(seen.contour)


@pytest.mark.parametrize("augment", ["radial", "normal"])
@pytest.mark.parametrize("name", [*SHIPPED, "disc", "square"])
@settings(max_examples=10)
@given(seed=st.integers(0, 99), turn=st.floats(-3, 3))
def test_a_convex_object_can_be_pushed_everywhere(name, augment, seed, turn):
    seen = observed(SHAPES[name], turn=turn)
    noise = np.random.default_rng(seed).normal(0, 2e-4, seen.contour.shape)
    assert push(augment).pushable(seen.contour + noise, seen.c).all()


def test_the_corner_inside_an_l_is_narrower_than_the_tool():
    contour, inward = straight(resample(ell(), 256))
    mask = pushable(contour, contour, inward, REACH)
    corner = np.array([0.05, 0.05]) - 0.16 / 3
    away = np.linalg.norm(contour - corner, axis=1)
    assert not mask[away < 0.005].any()
    assert mask[away > 0.015].all()


def test_a_slimmer_tool_goes_deeper_into_the_corner():
    contour = resample(ell(), 512)
    masks = [
        pushable(contour, contour, push(tool_radius=r).inward(contour), r + 0.002)
        for r in (0.003, 0.01, 0.015)
    ]
    blocked = [int(np.count_nonzero(~mask)) for mask in masks]
    assert 0 < blocked[0] < blocked[1] < blocked[2]


@pytest.mark.parametrize(
    ("degrees", "fits"), [(60, False), (90, False), (100, False), (112, True), (140, True)]
)
def test_how_sharp_a_corner_may_be(degrees, fits):
    """In a corner of 106 degrees a disc is stopped a quarter of its radius before the bottom."""
    half = np.radians(degrees / 2)
    notch = 0.05 * np.array([np.sin(half), np.cos(half)])
    plan = np.array(
        [(0, 0), notch, (0.09, notch[1]), (0.09, -0.06), (-0.09, -0.06), (-0.09, notch[1]), notch * (-1, 1)]
    )
    contour = resample(plan[::-1], 1024)
    bottom = int(np.argmin(np.linalg.norm(contour, axis=1)))
    inward = np.tile((0.0, -1.0), (len(contour), 1))
    assert bool(pushable(contour, contour, inward, REACH)[bottom]) == fits


def slot(width, depth=0.05):
    """A block with a slot from above."""
    w = width / 2
    return np.array(
        [(-0.08, -0.08), (0.08, -0.08), (0.08, 0), (w, 0), (w, -depth), (-w, -depth), (-w, 0), (-0.08, 0)]
    )


@pytest.mark.parametrize(("width", "fits"), [(0.02, False), (0.023, False), (0.027, True), (0.06, True)])
def test_the_bottom_of_a_slot_is_reached_by_a_tool_that_fits_into_it(width, fits):
    contour = resample(slot(width), 1024)
    bottom = int(np.argmin(np.linalg.norm(contour - (0, -0.05), axis=1)))
    down = np.tile((0.0, -1.0), (len(contour), 1))
    assert bool(pushable(contour, contour, down, REACH)[bottom]) == fits


def test_the_side_of_a_slot_lies_behind_the_other_side():
    """Coming from far away the tool would have to cross the object; from within the slot it need not."""
    contour = resample(slot(0.06), 512)
    inward = push().inward(contour)
    side = (np.abs(np.abs(contour[:, 0]) - 0.03) < 1e-6) & (np.abs(contour[:, 1] + 0.025) < 0.008)
    assert side.sum() > 10
    assert not pushable(contour, contour, inward, REACH)[side].any()
    assert pushable(contour, contour, inward, REACH, approach=0.03)[side].all()
    assert not pushable(contour, contour, inward, REACH, approach=0.05)[side].any()


def test_inside_a_ring_a_push_from_outside_ends_on_its_back():
    seen = observed(ring(270))
    mask, inner = push().pushable(seen.contour, seen.c), np.linalg.norm(seen.contour, axis=1) < 0.051
    assert mask[~inner].mean() > 0.95
    assert mask[inner].mean() < 0.6
    assert push().pushable(seen.contour, seen.c, approach=0.02)[inner].mean() > 0.9


def test_a_line_past_the_object_pushes_nothing():
    contour = resample(rectangle(), 128)
    sideways = np.tile((1.0, 0.0), (128, 1))
    start = np.add(contour, (0, 0.2))
    assert not pushable(contour, start, sideways, REACH).any()


@settings(max_examples=60)
@given(
    name=st.sampled_from(sorted(SHAPES)),
    augment=st.sampled_from(["radial", "normal"]),
    i=st.integers(0, 127),
    turn=st.floats(-3, 3),
)
def test_it_agrees_with_the_path_that_is_laid_out(name, augment, i, turn):
    """The contact of a path to a point that can be pushed is near it; of others it is not."""
    seen, layout = observed(SHAPES[name], turn=turn), push(augment)
    index = ROUND.indices(seen)
    arc = layout.effective(seen, ROUND).length
    path = layout.plan(np.array([arc[i] / arc[-1], 0.02]), seen, ROUND)
    wanted = float((seen.contour[index[i]] - path.start) @ path.direction) - layout.reach
    late = (path.approach - wanted) / layout.reach
    if -0.24 < late < 0.99 and not np.isclose(late, 0.0):
        assert layout.pushable(seen.contour, seen.c)[index[i]]
    if late < -0.26:
        assert not layout.pushable(seen.contour, seen.c)[index[i]]
