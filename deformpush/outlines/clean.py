"""From the closed lines of a file to one polygon without holes, and from that to few points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

Array = np.ndarray

WORTH_TELLING = 0.001
"""Pieces and holes smaller than this are not mentioned (of the object's area)."""
SCRIBBLE = 300
"""A line so many times as long as the drawing is large is no outline."""
FINEST = 1 / 20_000
"""Detail finer than this is dropped before anything else (of the drawing's size)."""
MOST_POINTS = 120
"""Of an outline."""


@dataclass(frozen=True)
class Piece:
    """The largest of what was drawn."""

    polygon: shapely.Polygon
    """Without holes."""
    notes: tuple[str, ...]
    """What was left out, filled or mended, for the user."""


def largest_piece(lines: Sequence[Array]) -> Piece:
    """Join closed lines `(V, 2)` of a drawing, take the largest piece, and fill its holes.

    Raises:
        ValueError: they cover no area, or are a scribble.
    """
    every = np.concatenate(lines)
    size = float(np.ptp(every, axis=0).max())
    length = sum(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in lines)
    if not size > 0:
        raise ValueError("covers no area")
    if length > SCRIBBLE * size:
        raise ValueError(
            f"has lines {length / size:.0f} times as long as it is large, {SCRIBBLE} times are allowed; "
            "keep the outline alone"
        )
    whole = [area for area in (_areal(_few(line, size * FINEST)) for line in lines) if not area.is_empty]
    crossed = any(not shapely.is_valid(shapely.Polygon(line)) for line in lines)
    pieces = sorted(_polygons(shapely.union_all(whole)), key=lambda piece: -piece.area)
    if not pieces:
        raise ValueError("covers no area")
    body = shapely.Polygon(pieces[0].exterior)
    notes = []
    if crossed:
        notes.append("mended:    a line crosses itself; look at the picture, whether the outline is meant so")
    others = [piece.area for piece in pieces[1:] if piece.area > WORTH_TELLING * body.area]
    if others:
        notes.append(
            f"pieces:    {len(others) + 1}; the largest is the object, the others cover "
            f"{sum(others) / body.area:.1%} of its area"
        )
    holes = [shapely.Polygon(ring).area for ring in pieces[0].interiors]
    holes += [
        one.area for one in whole if one.area < 0.98 * body.area and shapely.contains_properly(body, one)
    ]
    holes = [area for area in holes if area > WORTH_TELLING * body.area]
    if holes:
        notes.append(f"holes:     {len(holes)} filled, {sum(holes) / body.area:.1%} of its area")
    return Piece(body, tuple(notes))


def longer_side(polygon: shapely.Polygon) -> float:
    """Longer side of the smallest rectangle around it, turned as it may be."""
    corners = np.array(shapely.oriented_envelope(polygon).exterior.coords)
    return float(np.linalg.norm(np.diff(corners, axis=0), axis=1).max())


def simplified(polygon: shapely.Polygon, tolerance: float) -> tuple[shapely.Polygon, float]:
    """As few points as keep within a tolerance (m), and at most `MOST_POINTS`; how far it is off (m).

    Chords cut area off what is round. So the outline is moved outwards until its area is the old one.
    """
    while True:
        fewer = polygon.simplify(tolerance)
        if len(fewer.exterior.coords) <= MOST_POINTS:
            break
        tolerance *= 1.25
    grown = fewer.buffer((polygon.area - fewer.area) / fewer.length, join_style="mitre", mitre_limit=2.0)
    if isinstance(grown, shapely.Polygon) and len(grown.exterior.coords) <= MOST_POINTS + 10:
        fewer = shapely.Polygon(grown.exterior)
    return fewer, float(shapely.hausdorff_distance(polygon.exterior, fewer.exterior, densify=0.02))


def points_of(polygon: shapely.Polygon) -> Array:
    """Its corners `(V, 2)`, counter-clockwise, the first not repeated."""
    return np.array(shapely.geometry.polygon.orient(polygon).exterior.coords)[:-1]


def _few(line: Array, tolerance: float) -> shapely.Polygon:
    """The polygon of a line without detail finer than this."""
    closed = shapely.LineString(np.concatenate([line, line[:1]])).simplify(tolerance, preserve_topology=False)
    return shapely.Polygon(closed.coords) if len(closed.coords) >= 4 else shapely.Polygon()


def _areal(polygon: shapely.Geometry) -> shapely.Geometry:
    """What it covers, where its lines cross too."""
    if polygon.is_valid:
        return polygon
    return shapely.union_all(_polygons(shapely.make_valid(polygon, method="structure", keep_collapsed=False)))


def _polygons(shape: shapely.Geometry) -> list[shapely.Polygon]:
    parts = shapely.get_parts(shape).tolist()
    nested = [part for part in parts if isinstance(part, shapely.MultiPolygon)]
    found = [part for part in parts if isinstance(part, shapely.Polygon) and part.area > 0]
    return found + [part for group in nested for part in group.geoms]
