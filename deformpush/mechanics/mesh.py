"""Tetrahedral slabs: a grid mapped onto an outline, or prisms on a plane mesh; written as ASCII VTK."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deformpush.mechanics.rounding import NODES, rounded

# A cell's eight corners are numbered by bits (x + 2 y + 4 z); six tetrahedra share the diagonal 0-7 (Kuhn's
# subdivision), so faces of neighbouring cells match without any parity rule.
_KUHN = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])


@dataclass(frozen=True)
class TetMesh:
    """Nodes `(N, 3)` in metres and tetrahedra `(T, 4)`, all of positive volume. z = 0 is the underside."""

    nodes: np.ndarray
    tetrahedra: np.ndarray

    @property
    def volumes(self) -> np.ndarray:
        """Volume of each tetrahedron (m^3) `(T,)`."""
        return tet_volumes(self.nodes, self.tetrahedra)

    def surface(self) -> np.ndarray:
        """Triangles `(F, 3)` on the boundary, wound so that normals point outward."""
        a, b, c, d = self.tetrahedra.T
        faces = np.concatenate([np.stack(f, 1) for f in ((a, c, b), (a, b, d), (a, d, c), (b, c, d))])
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        return faces[first[count == 1]]


def tet_volumes(nodes: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    """Signed volumes (m^3) `(T,)`: det[b-a, c-a, d-a] / 6."""
    a, b, c, d = (nodes[tetrahedra[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def slab(outline: np.ndarray, thickness: float, cell: float) -> TetMesh:
    """Mesh a slab whose plan is a star-shaped polygon.

    A regular grid over the bounding box is mapped onto the outline: every grid point keeps its direction and
    its relative distance from the centre, measured in the box's own "radius". A rectangle is reproduced
    exactly.

    Args:
        outline: polygon `(V, 2)` (m), counter-clockwise, star-shaped about the centre of its bounding box.
        thickness: metres.
        cell: wanted edge length in the plane, metres; `max(1, round(t / cell))` layers through the thickness.

    Raises:
        ValueError: the outline covers no area or is not star-shaped about its box centre, or a mapped cell
            is inverted.
    """
    lo, hi = outline.min(0), outline.max(0)
    if not np.all(hi > lo):
        raise ValueError(f"outline: covers no area, it reaches from {lo.tolist()} to {hi.tolist()}")
    centre, half = (lo + hi) / 2, (hi - lo) / 2
    nx, ny = (max(2, round(s / cell)) for s in (hi - lo))
    nz = layers(thickness, cell)
    gx, gy = np.meshgrid(np.linspace(-1, 1, nx + 1), np.linspace(-1, 1, ny + 1), indexing="ij")
    square = np.stack([gx.ravel(), gy.ravel()], 1)
    plan = rounded(centre + half * _square_to_outline(square, (outline - centre) / half), NODES)
    z = np.linspace(0.0, thickness, nz + 1)
    nodes = np.concatenate([np.column_stack([plan, np.full(len(plan), h)]) for h in z])

    index = np.arange(len(nodes)).reshape(nz + 1, nx + 1, ny + 1)
    corners = np.stack(
        [index[k : nz + k, i : nx + i, j : ny + j].ravel() for k in (0, 1) for j in (0, 1) for i in (0, 1)],
        axis=1,
    )  # bit order x + 2 y + 4 z
    _, i, j = (axis.ravel() for axis in np.indices((nz, nx, ny)))
    tetrahedra = _subdivide(corners, i < nx // 2, j < ny // 2)
    volumes = tet_volumes(nodes, tetrahedra)
    if volumes.min() <= 0:
        raise ValueError(
            f"outline: {np.sum(volumes <= 0)} cells are inverted; it must be star-shaped and smooth"
        )
    return TetMesh(nodes, tetrahedra)


def layers(thickness: float, cell: float) -> int:
    """Layers of cells of about this size through a thickness (m)."""
    return max(1, round(thickness / cell))


def prisms(points: np.ndarray, triangles: np.ndarray, thickness: float, count: int) -> TetMesh:
    """Stand `count` layers of prisms on a plane mesh; three tetrahedra make each.

    Each side of a prism is cut from the bottom of its point of lower index to the top of the other, so that
    neighbours cut the side they share alike (Dompierre and others, 8th Int. Meshing Roundtable, 1999).

    Args:
        points: `(N, 2)` (m).
        triangles: `(T, 3)` into the points, counter-clockwise.
        thickness: metres.
        count: layers.
    """
    n = len(points)
    levels = np.linspace(0.0, thickness, count + 1)
    nodes = np.concatenate([np.column_stack([points, np.full(n, z)]) for z in levels])
    a, b, c = np.sort(triangles, axis=1).T
    cut = np.array([(a, b, c, c + n), (a, b, b + n, c + n), (a, a + n, b + n, c + n)])
    lowest = cut.transpose(2, 0, 1).reshape(-1, 4)
    inverted = tet_volumes(nodes, lowest) < 0
    lowest[inverted] = lowest[inverted][:, [0, 1, 3, 2]]
    return TetMesh(nodes, np.concatenate([lowest + k * n for k in range(count)]))


def _subdivide(corners: np.ndarray, left: np.ndarray, lower: np.ndarray) -> np.ndarray:
    """Six tetrahedra a cell, mirrored in the left and in the lower half.

    So the diagonals point from the middle of the slab to its corners, where a smooth outline flattens the
    corner cell: the other diagonal would cut off a sliver there. Mirrored halves still match, as a mirrored
    face keeps its diagonal.
    """
    cells = np.arange(8) ^ (left.astype(int) + 2 * lower.astype(int))[:, None]
    tetrahedra = np.take_along_axis(corners, cells, axis=1)[:, _KUHN]
    mirrored = left ^ lower
    tetrahedra[mirrored] = tetrahedra[mirrored][..., [0, 2, 1, 3]]
    return tetrahedra.reshape(-1, 4)


def _square_to_outline(square: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Map points of [-1, 1]^2 radially: the square's rim becomes the outline (both about the origin)."""
    if np.any(_cross(outline, np.roll(outline, -1, 0)) <= 0):
        raise ValueError(
            "outline: must be counter-clockwise and star-shaped about the centre of its bounding box"
        )
    reach = np.max(np.abs(square), axis=1)  # 1 on the rim of the square, 0 in the middle
    rim = square / np.where(reach > 0, reach, 1)[:, None]
    angle = np.arctan2(rim[:, 1], rim[:, 0])
    return rim * (reach * _radius(outline, angle) / np.maximum(np.linalg.norm(rim, axis=1), 1e-12))[:, None]


def _radius(polygon: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Distance from the origin to a star-shaped polygon in the given directions."""
    start, edge = polygon, np.roll(polygon, -1, 0) - polygon
    ray = np.stack([np.cos(angles), np.sin(angles)], 1)
    denominator = _cross(ray[:, None], edge[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        along = _cross(start, edge)[None] / denominator
        on_edge = _cross(start[None], ray[:, None]) / denominator
    hit = (along > 0) & (on_edge >= -1e-9) & (on_edge <= 1 + 1e-9)
    return np.max(np.where(hit, along, 0.0), axis=1)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def write_vtk(mesh: TetMesh, path: Path) -> None:
    """Write the form PyBullet reads: legacy ASCII, tetrahedra only, one point and one cell a line."""
    points = "\n".join(" ".join(f"{v:.9g}" for v in p) for p in mesh.nodes)
    cells = "\n".join("4 " + " ".join(map(str, t)) for t in mesh.tetrahedra)
    types = "\n".join(["10"] * len(mesh.tetrahedra))
    path.write_text(
        "# vtk DataFile Version 2.0\nslab\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS {len(mesh.nodes)} double\n{points}\n\n"
        f"CELLS {len(mesh.tetrahedra)} {5 * len(mesh.tetrahedra)}\n{cells}\n\n"
        f"CELL_TYPES {len(mesh.tetrahedra)}\n{types}\n"
    )
