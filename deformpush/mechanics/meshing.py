"""An outline becomes a tetrahedral slab that a simulation can trust, or is refused with a reason."""

from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np

from deformpush.mechanics.mesh import TetMesh, layers, prisms, slab
from deformpush.mechanics.outline import SimpleOutline, neck, simple
from deformpush.mechanics.triangulation import refuse_too_many, triangles_in, triangulate

Array = np.ndarray

Layout = Literal["auto", "grid", "free"]
"""How cells lie: a grid mapped onto a star-shaped outline, triangles in any, or the first that is good."""

SMALLEST_ANGLE = 12.0
"""Triangles of the plan must have no smaller one (degrees)."""
WORST_ASPECT = 12.0
"""No tetrahedron may be longer than this, over its smallest height (-)."""
NECK_CELLS = 1.0
"""The outline must be nowhere thinner (cells)."""
VOLUME_ERROR = 0.01
"""The volume must be as near to that of the outline times the thickness (-)."""


@dataclass(frozen=True)
class Quality:
    """What the cells of a slab are like."""

    smallest_angle: float
    """Of all triangles of the plan (degrees); 60 where all are regular."""
    worst_aspect: float
    """Longest edge of a tetrahedron over its smallest height (-); 1.2 for a regular one."""
    neck_cells: float
    """Width of the outline where it is thinnest (cells)."""
    volume_error: float
    """Volume over that of the outline times the thickness, minus 1."""


@dataclass(frozen=True)
class MeshedSlab:
    """A mesh, and how it came about."""

    mesh: TetMesh
    layout: Literal["grid", "free"]
    quality: Quality
    outline: SimpleOutline
    """As it was meshed, and whether it was given clockwise."""


def mesh_outline(outline: Array, thickness: float, cell: float, layout: Layout = "auto") -> MeshedSlab:
    """Mesh a slab of any simple outline.

    Args:
        outline: polygon `(V, 2)` (m); one that runs clockwise is reversed.
        thickness: metres.
        cell: wanted edge length in the plane, metres; `max(1, round(t / cell))` layers through the thickness.
        layout: auto is the grid where the outline is star-shaped and the cells are good enough, else free.

    Raises:
        ValueError: in one line, which of outline, thickness, cell and mesh is to be changed, and how.
    """
    for name, value in (("thickness", thickness), ("cell", cell)):
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name}: {value:g} m must be a finite number above 0")
    plan = simple(outline)
    refuse_too_many(3 * layers(thickness, cell) * triangles_in(plan.area, cell), cell)
    if layout != "free":
        try:
            return _grid(plan, thickness, cell)
        except ValueError as error:
            if layout == "grid":
                raise ValueError(f"{error}; or choose mesh=free") from error
    return _free(plan, thickness, cell)


def quality(mesh: TetMesh, plan: SimpleOutline, thickness: float, cell: float) -> Quality:
    """What the cells of a slab are like.

    Raises:
        ValueError: they are not good enough: which of outline and cell is to be changed, and how.
    """
    under = mesh.surface()
    under = under[np.all(mesh.nodes[under][:, :, 2] < 1e-9, axis=1)]
    angles = _angles(mesh.nodes[under][:, :, :2])
    corners = np.bincount(under.ravel(), angles.ravel(), under.max() + 1)  # at a point inside: 360 degrees
    found = Quality(
        float(angles.min()),
        _worst_aspect(mesh),
        neck(plan.points, cell / 4) / cell,
        float(mesh.volumes.sum()) / (plan.area * thickness) - 1,
    )
    problem = None
    if corners.min() < SMALLEST_ANGLE:
        x, y = mesh.nodes[np.argmin(corners), :2]
        problem = (
            f"outline: its corner near [{x:.3g}, {y:.3g}] has {corners.min():.1f} degrees, must have "
            f"{SMALLEST_ANGLE:g} or more; blunt it"
        )
    elif found.neck_cells < NECK_CELLS - 1e-6:
        problem = (
            f"cell: {cell:g} m is more than the {found.neck_cells * cell:.2g} m that the outline measures "
            "where it is thinnest; make the cell smaller, or the outline thicker there"
        )
    elif found.smallest_angle < SMALLEST_ANGLE:
        problem = (
            f"cell: {cell:g} m leaves an angle of {found.smallest_angle:.1f} degrees in the mesh, "
            f"{SMALLEST_ANGLE:g} is the least; make the cell smaller"
        )
    elif found.worst_aspect > WORST_ASPECT:
        problem = (
            f"cell: {cell:g} m makes tetrahedra {found.worst_aspect:.0f} times as long as high, "
            f"{WORST_ASPECT:g} times are allowed; make it smaller, at most a few times the thickness"
        )
    elif abs(found.volume_error) > VOLUME_ERROR:
        problem = (
            f"cell: {cell:g} m makes a mesh whose volume is {found.volume_error:+.1%} off the outline's, "
            f"{VOLUME_ERROR:.0%} is allowed; make it smaller"
        )
    if problem:
        raise ValueError(problem)
    return found


def _grid(plan: SimpleOutline, thickness: float, cell: float) -> MeshedSlab:
    """Six tetrahedra in each cell of a grid over the bounding box."""
    box = float(np.prod(np.ptp(plan.points, axis=0)))
    refuse_too_many(6 * layers(thickness, cell) * box / cell**2, cell)
    mesh = slab(plan.points, thickness, cell)
    return MeshedSlab(mesh, "grid", quality(mesh, plan, thickness, cell), plan)


def _free(plan: SimpleOutline, thickness: float, cell: float) -> MeshedSlab:
    """Prisms over triangles, three tetrahedra each."""
    flat = triangulate(plan, cell)
    mesh = prisms(flat.points, flat.triangles, thickness, layers(thickness, cell))
    return MeshedSlab(mesh, "free", quality(mesh, plan, thickness, cell), plan)


def _angles(corners: Array) -> Array:
    """Angles (degrees) `(T, 3)` of triangles `(T, 3, 2)`."""
    on, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cross = on[..., 0] * back[..., 1] - on[..., 1] * back[..., 0]
    return np.degrees(np.abs(np.arctan2(cross, np.sum(on * back, axis=-1))))


def _worst_aspect(mesh: TetMesh) -> float:
    """Longest edge over smallest height of the tetrahedron where it is largest."""
    corners = mesh.nodes[mesh.tetrahedra]
    edges = [corners[:, i] - corners[:, j] for i, j in combinations(range(4), 2)]
    faces = [
        np.cross(corners[:, j] - corners[:, i], corners[:, k] - corners[:, i])
        for i, j, k in combinations(range(4), 3)
    ]
    longest = np.max([np.linalg.norm(edge, axis=1) for edge in edges], axis=0)
    largest = np.max([np.linalg.norm(face, axis=1) / 2 for face in faces], axis=0)
    return float(np.max(longest * largest / (3 * mesh.volumes)))
