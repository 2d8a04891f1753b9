"""From closed lines to an object: piece, size, few points, mesh, YAML and the picture to check it by."""

from dataclasses import dataclass

import numpy as np
import shapely
from shapely import affinity

from deformpush.mechanics.meshing import MeshedSlab, mesh_outline
from deformpush.mechanics.outline import simple
from deformpush.outlines import sheet
from deformpush.outlines.clean import largest_piece, longer_side, points_of, simplified
from deformpush.outlines.drawing import Drawing, counted
from deformpush.outlines.overlay import Overlay
from deformpush.outlines.thin import Meshed, meshed, without_noise

Array = np.ndarray

TOLERANCE_NOISE = 0.2
"""Outlines of pictures are simplified within this (of what means nothing in them)."""
TIP_PX = 2.0
"""A tip that sticks out by so much is a corner that is rounded off by the lens."""
TOLERANCE = 1 / 2000
"""And all within this (of the longer side)."""


@dataclass(frozen=True)
class Wanted:
    """What the user asks for."""

    name: str
    thickness: float
    """m"""
    cell: float | None
    """m; None: it is chosen."""
    metre: float | None
    """Length of the file's unit (m)."""
    length: float | None
    """Or of the object's longer side (m)."""


@dataclass(frozen=True)
class Made:
    """An object."""

    text: str
    """Its YAML."""
    lines: tuple[str, ...]
    """What is to be said of it."""
    overlay: Overlay
    size: float
    """Largest distance of two of its points (m)."""


def make(drawing: Drawing, wanted: Wanted, preset: sheet.Preset, head: list[str], cell: float) -> Made:
    """Make an object.

    Args:
        drawing: what the file shows.
        wanted: what is asked for.
        preset: whose material it has.
        head: comment at the top of the YAML.
        cell: of the preset (m).

    Raises:
        ValueError: in one line, why no object comes of it.
    """
    piece = largest_piece(drawing.lines)
    drawn = without_noise(piece.polygon, drawing.noise, TIP_PX) if drawing.noise else piece.polygon
    metre = wanted.metre or (wanted.length or 0.0) / longer_side(drawn)
    whole = affinity.scale(drawn, metre, metre, origin=(0, 0))
    simple(points_of(whole.simplify(1e-3 * longer_side(whole))))  # says what is wrong with its size at once
    tolerance = max(TOLERANCE * longer_side(whole), TOLERANCE_NOISE * drawing.noise * metre)
    plan, _ = simplified(whole, tolerance)
    found = meshed(plan, wanted.thickness, cell, wanted.cell)
    plan = simplified(found.polygon, tolerance)[0] if found.cut else found.polygon
    origin = np.array([plan.centroid.x, plan.centroid.y])
    points = sheet.rounded(points_of(plan) - origin)
    slab = mesh_outline(points, wanted.thickness, found.cell)
    shape = sheet.Shape(points, wanted.thickness, found.cell, slab.mesh)
    kept = shapely.Polygon(points + origin)
    off = shapely.hausdorff_distance(
        kept.exterior, (found.polygon if found.cut else whole).exterior, densify=0.02
    )
    across = longer_side(kept)
    lines = (*piece.notes, *_cut(found, origin), *_measures(shape, across, kept.area / across, off, slab))
    overlay = Overlay(
        f"{wanted.name}: {across * 1e3:.0f} mm long, {kept.area * 1e4:.1f} cm², {len(points)} points",
        (points + origin) * 1e3,
        origin * 1e3,
        slab,
        tuple(np.array(part.exterior.coords) * 1e3 for part in found.cut),
        drawing.picture,
        metre * 1e3,
    )
    size = float(shapely.minimum_bounding_radius(kept)) * 2
    return Made(sheet.text(shape, preset, head), lines, overlay, size)


def _cut(found: Meshed, origin: Array) -> list[str]:
    """What was cut off, and where."""
    if not found.thinner:
        return []
    share = sum(part.area for part in found.cut) / found.polygon.area
    places = ", ".join(
        f"[{x:.0f}, {y:.0f}]" for x, y in (1e3 * (np.array(p.centroid.coords)[0] - origin) for p in found.cut)
    )
    what = f"{counted(len(found.cut), 'part')} at {places} mm" if found.cut else "no more than corners"
    return [
        f"cut off:   {what}, thinner than {found.thinner * 1e3:.1f} mm, {share:.1%} of its area; a smaller "
        "--cell keeps more"
    ]


def _measures(
    shape: sheet.Shape, across: float, mean_width: float, off: float, slab: MeshedSlab
) -> list[str]:
    low, high = shape.points.min(axis=0), shape.points.max(axis=0)
    quality = slab.quality
    return [
        f"outline:   {len(shape.points)} points within {off * 1e3:.2f} mm; {(high - low)[0] * 1e3:.0f} x "
        f"{(high - low)[1] * 1e3:.0f} mm, {across * 1e3:.0f} mm long, {mean_width * 1e3:.0f} mm wide on "
        f"average, {shape.area * 1e4:.1f} cm2",
        f"mesh:      cell {shape.cell * 1e3:.3g} mm, {len(shape.mesh.nodes)} nodes, "
        f"{len(shape.mesh.tetrahedra)} tetrahedra; smallest angle {quality.smallest_angle:.0f} degrees, "
        f"aspect {quality.worst_aspect:.1f}, volume {quality.volume_error:+.2%}, thinnest neck "
        f"{quality.neck_cells * shape.cell * 1e3:.3g} mm = {quality.neck_cells:.1f} cells",
    ]
