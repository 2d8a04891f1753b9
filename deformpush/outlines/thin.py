"""A cell size with which an outline meshes well, and what must be cut off where it is too thin for any."""

from dataclasses import dataclass

import numpy as np
import shapely

from deformpush.mechanics.meshing import MeshedSlab, mesh_outline
from deformpush.mechanics.outline import neck
from deformpush.outlines.clean import points_of

ACROSS = 3.0
"""Cells across the outline where it is thinnest, where that can be had."""
MOST_TETRAHEDRA = 2000
"""A push of more takes seconds."""
CROSSED = 1.05
"""What is cut off is thinner than so many of the finest cells that are allowed."""
CUTS = (0.0, 0.2, 0.5, 1.0)
"""So much of that is tried, one after the other: nothing is cut off that need not be."""
CORNER = 0.75
"""What sticks out of the rest by less is a corner (half of the width)."""
MOST_LOST = 0.3
"""Objects that would lose more are refused (of the area)."""
LOST = 2e-3
"""Smaller parts are not worth telling (of the area)."""
STEP = 0.88
"""From one cell to the next finer one that is tried."""


@dataclass(frozen=True)
class Meshed:
    """An outline that meshes, and how."""

    polygon: shapely.Polygon
    cell: float
    slab: MeshedSlab
    cut: tuple[shapely.Polygon, ...]
    """Parts that were cut off."""
    thinner: float = 0.0
    """They were thinner than this (m)."""


def meshed(polygon: shapely.Polygon, thickness: float, wanted: float, cell: float | None) -> Meshed:
    """Mesh an outline (m), whole if that can be, else without its thinnest parts.

    Args:
        polygon: without holes, in metres.
        thickness: metres.
        wanted: cell of the object whose material it has (m): no coarser one is chosen.
        cell: as the user wants it (m); None: it is chosen.

    Raises:
        ValueError: no mesh is good enough, as `mesh_outline` says.
    """
    finest = cell or _finest(polygon, thickness)
    refused: ValueError | None = None
    for part_of in CUTS:
        thinner = part_of * CROSSED * finest
        try:
            plan = without_thin(polygon, thinner) if thinner else polygon
            slab, at = _fine_enough(plan, thickness, cell or wanted, finest)
        except ValueError as error:
            refused = refused or error
            continue
        share = 1 - plan.area / polygon.area
        if share > MOST_LOST:
            refused = ValueError(
                f"outline: {share:.0%} of it is thinner than {thinner * 1e3:.2g} mm, which no mesh of "
                f"{MOST_TETRAHEDRA} tetrahedra resolves; give a smaller --cell, or a simpler outline"
            )
            break
        lost = [part for part in shapely.get_parts(polygon.difference(plan)) if part.area > LOST * plan.area]
        return Meshed(plan, at, slab, tuple(lost), thinner)
    assert refused is not None
    raise refused


def without_thin(polygon: shapely.Polygon, thinner: float, corner: float = CORNER) -> shapely.Polygon:
    """What is left of an outline when all parts of it thinner than this are cut off; corners stay.

    Raises:
        ValueError: nothing is left.
    """
    disc = thinner / 2
    core = polygon.buffer(-disc, quad_segs=8)
    if core.is_empty:
        raise ValueError("outline: is nowhere thick enough to be told from noise, or to be meshed")
    body = _largest(core).buffer(disc, quad_segs=8)
    # A disc does not reach into corners: what it leaves there is no thin part, and is put back.
    left = shapely.get_parts(polygon.difference(body.buffer(disc * 1e-3)))
    near = body.buffer(corner * disc)
    corners = [part for part in left if near.contains(part)]
    body = shapely.union_all([body.buffer(disc * 2e-3), *corners]).intersection(polygon)
    return shapely.Polygon(_largest(_largest(body).simplify(disc * 0.03)).exterior)


def without_noise(polygon: shapely.Polygon, width: float, tip: float) -> shapely.Polygon:
    """An outline without slits and whiskers narrower than `width`; tips that stick out by `tip` stay."""
    filled = _largest(polygon.buffer(width / 2, quad_segs=8).buffer(-width / 2, quad_segs=8))
    return without_thin(shapely.Polygon(filled.exterior), width, 2 * tip / width)


def _fine_enough(
    plan: shapely.Polygon, thickness: float, wanted: float, finest: float
) -> tuple[MeshedSlab, float]:
    """The coarsest mesh of an outline that is good enough, and its cell (m).

    Raises:
        ValueError: none is.
    """
    points = points_of(plan)
    x0, y0, x1, y1 = plan.bounds
    width = neck(points, max(x1 - x0, y1 - y0) / 60)
    cell = round(max(finest, min(wanted, width / ACROSS)), 4)
    while True:
        try:
            return mesh_outline(points, thickness, cell), cell
        except ValueError:
            if cell <= finest:
                raise
        cell = max(finest, round(cell * STEP, 4))


def _largest(shape: shapely.Geometry) -> shapely.Polygon:
    return max(shapely.get_parts(shape), key=lambda part: part.area)


def _finest(polygon: shapely.Polygon, thickness: float) -> float:
    """The cell (m) that makes as many tetrahedra as are allowed: three a prism, layers by the thickness."""
    for layers in range(1, 100):
        triangles = MOST_TETRAHEDRA / (3 * layers)
        cell = float(np.sqrt(polygon.area / triangles / (np.sqrt(3) / 4)))
        if round(thickness / cell) <= layers:
            return round(cell, 4)
    raise ValueError(f"thickness: {thickness:g} m is too much for an outline of {polygon.area:.3g} m^2")
