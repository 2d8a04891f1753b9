"""A cell size with which an outline meshes well, and what must be cut off where it is too thin for any."""

from dataclasses import dataclass

import numpy as np
import shapely

from deformpush.mechanics.meshing import MeshedSlab, mesh_outline
from deformpush.mechanics.outline import neck
from deformpush.outlines.clean import points_of

ACROSS = 3.0
"""Cells across the outline where it is thinnest, where that can be had."""
MOST_TETRAHEDRA = 3000
"""A push of more takes seconds."""
CROSSED = 1.05
"""What is cut off is thinner than so many of the finest cells that are allowed."""
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
    width = neck(points_of(polygon), _largest(polygon) / 60)
    finest = cell or _finest(polygon, thickness)
    start = cell or max(finest, min(wanted, max(width / ACROSS, finest)))
    refused: ValueError | None = None
    at = start
    while at >= finest * (1 - 1e-9):
        try:
            return _whole(polygon, thickness, at)
        except ValueError as error:
            refused = refused or error
            at = at * STEP if at * STEP >= finest or at <= finest * 1.0001 else finest
    if width > finest * CROSSED * 1.2:
        assert refused is not None
        raise refused
    return _opened(polygon, thickness, finest, CROSSED * finest)


def _whole(polygon: shapely.Polygon, thickness: float, cell: float) -> Meshed:
    cell = round(cell, 4)
    return Meshed(polygon, cell, mesh_outline(points_of(polygon), thickness, cell), ())


def _opened(polygon: shapely.Polygon, thickness: float, cell: float, thinner: float) -> Meshed:
    """Mesh what is left of an outline when all parts of it thinner than this are cut off (m)."""
    disc = thinner / 2
    core = polygon.buffer(-disc, quad_segs=8)
    if core.is_empty:
        raise ValueError(f"outline: is nowhere thicker than {thinner * 1e3:.2g} mm")
    parts = sorted(shapely.get_parts(core), key=lambda part: -part.area)
    body = parts[0].buffer(disc, quad_segs=8)
    # A disc does not reach into corners: what it leaves there is no thin part, and is put back.
    left = shapely.get_parts(polygon.difference(body.buffer(disc * 1e-3)))
    near = body.buffer(disc * 0.75)
    corners = [part for part in left if near.contains(part)]
    body = shapely.union_all([body.buffer(disc * 2e-3), *corners])
    body = shapely.Polygon(max(shapely.get_parts(body), key=lambda part: part.area).exterior)
    body = body.intersection(polygon).simplify(disc * 0.03)
    body = shapely.Polygon(max(shapely.get_parts(body), key=lambda part: part.area).exterior)
    slab = mesh_outline(points_of(body), thickness, cell)
    lost = [part for part in shapely.get_parts(polygon.difference(body)) if part.area > 2e-3 * body.area]
    return Meshed(body, cell, slab, tuple(lost), thinner)


def _finest(polygon: shapely.Polygon, thickness: float) -> float:
    """The cell (m) that makes as many tetrahedra as are allowed: three a prism, layers by the thickness."""
    for layers in range(1, 100):
        triangles = MOST_TETRAHEDRA / (3 * layers)
        cell = float(np.sqrt(polygon.area / triangles / (np.sqrt(3) / 4)))
        if round(thickness / cell) <= layers:
            return round(cell, 4)
    raise ValueError(f"thickness: {thickness:g} m is too much for an outline of {polygon.area:.3g} m^2")


def _largest(polygon: shapely.Polygon) -> float:
    x0, y0, x1, y1 = polygon.bounds
    return max(x1 - x0, y1 - y0)
