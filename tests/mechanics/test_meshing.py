"""Slabs of any outline: matching faces, true volume, gates with a reason, and the old grids unchanged."""

from collections import Counter
from hashlib import sha256
from itertools import combinations
from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import rotation, signed_area
from deformpush.mechanics.mesh import TetMesh, prisms, slab
from deformpush.mechanics.meshing import Quality, mesh_outline
from deformpush.mechanics.triangulation import triangulate
from tests.outlines import OUTLINES, RANDOM, disc, ell, rectangle, tee

RECT = rectangle()
SHIPPED = {
    "dough": "0d620b5adb459e4a",
    "fish_fillet": "0d8d35f2fea3f5cd",
    "meat": "f4d36e0698719abd",
    "pork": "0b24d6f335fd5a9f",
    "rect": "2b8539eb49f520fa",
    "silicone": "da533ac2f90c6817",
    "tofu": "a3f2ac3f1002dc46",
}
"""Digest of nodes, rounded to a nanometre, and tetrahedra of each object's grid."""
IN_GRID = {"rect", "square", "disc"}


def assert_conforms(mesh: TetMesh) -> None:
    """Neighbours share whole faces, the surface is closed, nothing is inverted."""
    assert mesh.volumes.min() > 0
    faces = Counter(tuple(sorted(f)) for tet in mesh.tetrahedra.tolist() for f in combinations(tet, 3))
    assert set(faces.values()) <= {1, 2}
    surface = mesh.surface()
    assert {tuple(sorted(f)) for f in surface.tolist()} == {f for f, n in faces.items() if n == 1}
    edges = Counter((a, b) for f in surface.tolist() for a, b in zip(f, f[1:] + f[:1], strict=True))
    assert all(edges[b, a] == n == 1 for (a, b), n in edges.items()), "each edge once in either direction"
    assert len(np.unique(surface)) - len(edges) // 2 + len(surface) == 2  # Euler: one body without holes
    a, b, c = (mesh.nodes[surface[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(mesh.volumes.sum())  # normals outward


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_objects_keep_their_meshes_to_the_bit(name):
    """Results that were published stand on them."""
    sheet = config.build(compose([f"object={name}"]).object)
    assert sheet.slab.layout == "grid"
    mesh = sheet.slab.mesh
    if name in ("rect", "silicone", "tofu"):  # the cosines of others may differ between machines
        assert sha256(mesh.nodes.tobytes() + mesh.tetrahedra.tobytes()).hexdigest()[:16] == SHIPPED[name]
    before = slab(np.array(sheet.outline), sheet.thickness, sheet.cell)
    np.testing.assert_array_equal(mesh.nodes, before.nodes)
    np.testing.assert_array_equal(mesh.tetrahedra, before.tetrahedra)
    np.testing.assert_array_equal(sheet.polygon, sheet.outline)


@pytest.mark.parametrize("layers", [1, 2, 3])
@pytest.mark.parametrize("name", OUTLINES)
def test_any_outline_becomes_a_slab_that_conforms(name, layers):
    made = mesh_outline(OUTLINES[name], 0.0133 * layers, 0.0133, "free")
    assert_conforms(made.mesh)
    assert made.layout == "free"
    height = made.mesh.nodes[:, 2]
    np.testing.assert_allclose(np.unique(height), np.arange(layers + 1) * 0.0133, atol=1e-15)
    assert made.mesh.volumes.sum() == pytest.approx(signed_area(OUTLINES[name]) * 0.0133 * layers, rel=3e-3)


@pytest.mark.parametrize("name", OUTLINES)
def test_a_grid_where_the_outline_is_star_shaped_triangles_where_not(name):
    made = mesh_outline(OUTLINES[name], 0.02, 0.0133)
    assert made.layout == ("grid" if name in IN_GRID else "free")
    assert_conforms(made.mesh)


def test_the_grid_gives_way_where_it_is_too_bad():
    """A star is star-shaped, but its tips crush the corners of the grid."""
    with pytest.raises(ValueError, match=r"^cell: .*; or choose mesh=free$"):
        mesh_outline(OUTLINES["star"], 0.02, 0.0133, "grid")
    assert mesh_outline(OUTLINES["star"], 0.02, 0.0133).layout == "free"


def test_the_quality_is_what_the_mesh_has():
    made = mesh_outline(RECT, 0.02, 0.02)
    assert made.quality.smallest_angle == pytest.approx(45)
    assert made.quality.worst_aspect == pytest.approx(np.sqrt(3) / (1 / np.sqrt(2)))  # of a cube cut in six
    assert made.quality.neck_cells == pytest.approx(5, rel=0.01)
    assert made.quality.volume_error == pytest.approx(0, abs=1e-12)
    flat = mesh_outline(RECT, 0.005, 0.02)
    assert flat.quality.worst_aspect > 1.5 * made.quality.worst_aspect
    round_one = mesh_outline(disc(0.07, 360), 0.02, 0.02, "grid")
    volume = round_one.mesh.volumes.sum() / (0.02 * signed_area(disc(0.07, 360)))
    assert round_one.quality.volume_error == pytest.approx(volume - 1)
    assert round_one.quality.volume_error < -5e-3
    assert isinstance(made.quality, Quality)


@pytest.mark.parametrize("layout", ["auto", "grid", "free"])
def test_a_clockwise_outline_is_meshed_and_said_to_be_reversed(layout):
    made, turned = (mesh_outline(outline, 0.02, 0.02, layout) for outline in (RECT, RECT[::-1]))
    assert (made.outline.reversed, turned.outline.reversed) == (False, True)
    assert signed_area(turned.outline.points) > 0
    np.testing.assert_array_equal(made.mesh.nodes, turned.mesh.nodes)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"outline": RECT * 1000}, "outline: is 200 m long, must be 0.02 to 1 m; "),
        ({"outline": RECT[[0, 2, 1, 3]]}, "outline: crosses or touches itself"),
        ({"outline": RECT * np.nan}, "outline: a coordinate is not a finite number"),
        (
            {"outline": np.array([(0, 0), (0.2, 0), (0.2, 0.03)])},
            r"outline: its corner near \[0, 0\] has 8.5 deg",
        ),
        ({"cell": 1e-4}, "cell: 0.0001 m makes some .* cells, 200000 are allowed; enlarge it"),
        (
            {"cell": 0.12},
            "cell: 0.12 m is more than the 0.1 m that the outline measures where it is thinnest",
        ),
        ({"cell": np.nan}, "cell: nan m must be a finite number above 0"),
        ({"cell": 0.0}, "cell: 0 m must be a finite number above 0"),
        ({"thickness": -0.02}, "thickness: -0.02 m must be a finite number above 0"),
        ({"thickness": np.inf}, "thickness: inf m must be a finite number above 0"),
        ({"thickness": 1e9}, "cell: 0.02 m makes some .* cells, 200000 are allowed"),
        ({"thickness": 5e-4}, "cell: 0.02 m makes tetrahedra 5. times as long as high, 12 times are allowed"),
        (
            {"outline": disc(0.07), "cell": 0.07},
            "cell: 0.07 m makes a mesh whose volume is .* off the outline's",
        ),
        (
            {"outline": ell(), "layout": "grid"},
            "outline: must be counter-clockwise and star-shaped .* mesh=free",
        ),
        ({"outline": tee(0.16, 0.02), "cell": 0.03}, "cell: 0.03 m is more than the 0.02 m that the outline"),
    ],
)
def test_what_cannot_be_meshed_is_refused_at_once_with_a_reason(change, message):
    began = process_time()
    with pytest.raises(ValueError, match=f"^{message}") as refused:
        mesh_outline(**({"outline": RECT, "thickness": 0.02, "cell": 0.02} | change))
    assert process_time() - began < 1.0
    assert "\n" not in str(refused.value)


def test_the_cell_that_a_neck_asks_for_is_taken():
    mesh_outline(tee(0.16, 0.02), 0.02, 0.02)


@settings(max_examples=200)
@given(
    seed=st.integers(0, 10**6),
    kind=st.sampled_from(sorted(RANDOM)),
    cell=st.floats(0.005, 0.03),
    layers=st.integers(1, 2),
)
def test_whatever_the_outline_its_mesh_is_good_or_refused_in_bounded_time(seed, kind, cell, layers):
    outline = RANDOM[kind](np.random.default_rng(seed))
    began, refused = process_time(), ""
    try:
        made = mesh_outline(outline, layers * cell, cell)
    except ValueError as reason:
        refused = str(reason)
    assert process_time() - began < 5.0
    if refused:
        assert refused.startswith(("outline: ", "cell: "))
        return
    assert_conforms(made.mesh)
    assert made.quality.smallest_angle >= 12
    assert made.quality.worst_aspect <= 12
    assert made.quality.neck_cells >= 0.999
    assert abs(made.quality.volume_error) <= 0.01


@settings(max_examples=30)
@given(turn=st.floats(0, 6.3), x=st.floats(-1, 1), name=st.sampled_from(sorted(OUTLINES)))
def test_an_outline_is_meshed_wherever_it_lies(turn, x, name):
    made = mesh_outline(OUTLINES[name] @ rotation(turn).T + (x, -x), 0.02, 0.02)
    assert abs(made.quality.volume_error) < 0.01
    assert made.quality.smallest_angle >= 12, "the gate; 18.7 was met, by a rectangle turned by 1.75 rad"


def test_prisms_are_cut_alike_whatever_the_order_of_a_triangle_s_corners():
    flat = triangulate(ell(), 0.02)
    rolled = np.roll(flat.triangles, 1, axis=1)
    first, second = (prisms(flat.points, triangles, 0.04, 2) for triangles in (flat.triangles, rolled))
    assert_conforms(second)
    assert len(first.tetrahedra) == 6 * len(flat.triangles)
    assert {tuple(sorted(t)) for t in first.tetrahedra.tolist()} == {
        tuple(sorted(t)) for t in second.tetrahedra.tolist()
    }
