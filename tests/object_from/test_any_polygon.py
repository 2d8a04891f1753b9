"""Whatever polygon a file holds: an object that meshes well comes of it, or a reason, in bounded time."""

from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.mechanics.meshing import mesh_outline
from deformpush.outlines.drawing import Drawing
from deformpush.outlines.make import Wanted, make
from deformpush.outlines.thin import MOST_TETRAHEDRA
from tests.object_from.making import polygon, preset
from tests.outlines import OUTLINES, RANDOM

rough = st.builds(
    lambda kind, seed: RANDOM[kind](np.random.default_rng(seed)),
    st.sampled_from(sorted(RANDOM)),
    st.integers(0, 10**6),
)
crossing = st.builds(
    lambda n, seed: np.random.default_rng(seed).uniform(-0.1, 0.1, (n, 2)),
    st.integers(3, 60),
    st.integers(0, 10**6),
)


def holds(outline: np.ndarray) -> bool:
    """Whether an object came of it; that it is good is checked here."""
    data, sheet, _ = preset()
    began, refused = process_time(), ""
    try:
        one = make(Drawing((outline,), ""), Wanted("a", 0.02, None, 1.0, None), data, [], sheet.cell)
    except ValueError as reason:
        refused = str(reason)
    assert process_time() - began < 8.0
    if refused:
        assert refused.startswith(("outline: ", "cell: ", "covers no area"))
        return False
    shape = polygon(one)
    assert shape.is_valid
    assert len(shape.exterior.coords) <= 132
    assert np.hypot(shape.centroid.x, shape.centroid.y) < 2e-5
    slab = one.overlay.slab
    again = mesh_outline(
        np.array(shape.exterior.coords)[:-1], 0.02, float(one.text.partition("cell: ")[2].split()[0])
    )
    np.testing.assert_array_equal(slab.mesh.nodes, again.mesh.nodes)
    assert len(slab.mesh.tetrahedra) < 1.5 * MOST_TETRAHEDRA
    return True


@settings(max_examples=10)
@given(outline=rough)
def test_a_rough_polygon(outline):
    holds(outline)


@settings(max_examples=10)
@given(outline=crossing)
def test_a_polygon_that_crosses_itself(outline):
    holds(outline)


@pytest.mark.slow
@settings(max_examples=400)
@given(outline=rough | crossing)
def test_many_more(outline):
    holds(outline)


def test_most_random_walks_become_objects():
    """Refusing all would be bounded, too."""
    walks = [RANDOM["random walk"](np.random.default_rng(seed)) for seed in range(20)]
    assert sum(map(holds, walks)) >= 12


@pytest.mark.parametrize("name", OUTLINES)
def test_outlines_that_people_draw_are_kept_whole(name):
    data, sheet, _ = preset()
    one = make(Drawing((OUTLINES[name],), ""), Wanted("a", 0.02, None, 1.0, None), data, [], sheet.cell)
    assert not [line for line in one.lines if line.startswith(("cut off", "mended", "pieces"))]
    assert len(one.overlay.slab.mesh.tetrahedra) <= MOST_TETRAHEDRA
