"""Tetrahedral slabs: volume, conformity, shape of the cells, and the file PyBullet reads."""

from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.checks.physics import rim
from deformpush.mechanics.geometry import signed_area
from deformpush.mechanics.mesh import slab, write_vtk
from tests.pictures import RECT, lobed
from tests.setups import setup

MEAT = setup("object=meat").object
SLABS = {
    "rect": (RECT, 0.02, 0.02),
    "rect fine": (RECT, 0.02, 0.013),
    "meat": (MEAT.polygon, MEAT.thickness, MEAT.cell),
    "meat fine": (MEAT.polygon, MEAT.thickness, MEAT.cell / 2),
    "disc": (lobed(0.08, 0.0, 1), 0.015, 0.015),
}


@st.composite
def star_shaped(draw):
    """Smooth outlines about the origin."""
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    depth, lobes, turn = draw(st.floats(0, 0.12)), draw(st.integers(2, 4)), draw(st.floats(0, 6.3))
    stretch = draw(st.floats(0.5, 1.0))
    r = 0.08 * (1 + depth * np.cos(lobes * angle + turn))
    return np.column_stack([r * np.cos(angle), stretch * r * np.sin(angle)])


def faces_of(mesh):
    return Counter(tuple(sorted(face)) for tet in mesh.tetrahedra.tolist() for face in combinations(tet, 3))


@pytest.mark.parametrize("name", SLABS)
def test_volume_is_plan_times_thickness(name):
    outline, thickness, cell = SLABS[name]
    mesh = slab(outline, thickness, cell)
    plan = rim(mesh, mesh.nodes)
    assert mesh.volumes.min() > 0
    assert mesh.volumes.sum() == pytest.approx(signed_area(plan) * thickness)
    # The rim's nodes lie on the outline; chords between them cut a little off a round one.
    assert mesh.volumes.sum() == pytest.approx(signed_area(outline) * thickness, rel=0.025)
    np.testing.assert_allclose([mesh.nodes[:, 2].min(), mesh.nodes[:, 2].max()], [0, thickness], atol=1e-12)


def test_a_rectangle_is_reproduced_exactly():
    mesh = slab(RECT, 0.02, 0.02)
    assert (len(mesh.nodes), len(mesh.tetrahedra)) == (11 * 6 * 2, 6 * 10 * 5)
    assert mesh.volumes.sum() == pytest.approx(0.2 * 0.1 * 0.02)
    np.testing.assert_allclose(
        np.unique(np.round(mesh.nodes[:, 0], 9)), np.linspace(-0.1, 0.1, 11), atol=1e-9
    )
    np.testing.assert_allclose(mesh.volumes, 0.02**3 / 6)


@settings(max_examples=25)
@given(outline=star_shaped(), layers=st.integers(1, 3))
def test_neighbours_share_whole_faces_and_the_surface_is_closed(outline, layers):
    mesh = slab(outline, 0.02 * layers, 0.02)
    shared = faces_of(mesh)
    assert set(shared.values()) == {1, 2}
    surface = mesh.surface()
    assert {tuple(sorted(f)) for f in surface.tolist()} == {f for f, n in shared.items() if n == 1}
    edges = Counter((a, b) for f in surface.tolist() for a, b in zip(f, f[1:] + f[:1], strict=True))
    assert all(edges[b, a] == n == 1 for (a, b), n in edges.items()), "each edge once in either direction"
    assert len(np.unique(surface)) - len(edges) // 2 + len(surface) == 2  # Euler: one body without holes
    a, b, c = (mesh.nodes[surface[:, i]] for i in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(mesh.volumes.sum())  # normals outward


@pytest.mark.parametrize("name", SLABS)
def test_no_slivers(name):
    mesh = slab(*SLABS[name])
    corners = mesh.nodes[mesh.tetrahedra]
    edges = np.stack([corners[:, i] - corners[:, j] for i, j in combinations(range(4), 2)], axis=1)
    rms = np.sqrt(np.mean(np.sum(edges**2, axis=2), axis=1))
    quality = mesh.volumes * 6 * np.sqrt(2) / rms**3  # 1 for a regular tetrahedron, 0 for a flat one
    assert quality.min() > 0.3
    assert mesh.volumes.max() < 4 * mesh.volumes.min()


def test_outlines_that_cannot_be_meshed_are_refused():
    with pytest.raises(ValueError, match=r"^outline: must be counter-clockwise and star-shaped"):
        slab(RECT[::-1], 0.02, 0.02)
    angle_iron = np.array(
        [(-0.1, -0.1), (0.1, -0.1), (0.1, -0.08), (-0.08, -0.08), (-0.08, 0.1), (-0.1, 0.1)]
    )
    with pytest.raises(ValueError, match=r"^outline: must be counter-clockwise and star-shaped"):
        slab(angle_iron, 0.02, 0.02)


def test_the_file_holds_the_mesh_in_its_order(tmp_path):
    mesh = slab(*SLABS["meat"])
    write_vtk(mesh, tmp_path / "slab.vtk")
    lines = (tmp_path / "slab.vtk").read_text().split("\n")
    n, t = len(mesh.nodes), len(mesh.tetrahedra)
    assert lines[:5] == [
        "# vtk DataFile Version 2.0",
        "slab",
        "ASCII",
        "DATASET UNSTRUCTURED_GRID",
        f"POINTS {n} double",
    ]
    points = np.array([line.split() for line in lines[5 : 5 + n]], float)
    np.testing.assert_allclose(points, mesh.nodes, atol=1e-9)
    assert lines[5 + n : 7 + n] == ["", f"CELLS {t} {5 * t}"]
    cells = np.array([line.split() for line in lines[7 + n : 7 + n + t]], int)
    np.testing.assert_array_equal(cells, np.column_stack([np.full(t, 4), mesh.tetrahedra]))
    assert lines[7 + n + t :] == ["", f"CELL_TYPES {t}", *["10"] * t, ""]
