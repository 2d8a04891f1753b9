"""Polygons as lists of points: CSV and GeoJSON."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from deformpush.errors import UserError, shortened
from deformpush.outlines.drawing import Array, Drawing, checked, counted, one_line, text

BYTES = 10_000_000
"""Largest file."""


def read_csv(path: Path) -> Drawing:
    """One polygon, a point x and y in each row; a first row of names is passed over.

    Numbers stand apart by commas, spaces or tabs; or by semicolons, and then they may have decimal commas.

    Raises:
        UserError: names the row that is not two numbers.
    """
    points: list[tuple[float, float]] = []
    for number, row in enumerate(text(path, BYTES).splitlines(), 1):
        if not row.strip() or row.lstrip().startswith("#"):
            continue
        parts = row.replace(",", ".").split(";") if ";" in row else re.split(r"\s*,\s*|\s+", row.strip())
        try:
            x, y = (float(part) for part in parts)
        except ValueError:
            if not points and number <= 2 and not any(map(_number, parts)):
                continue
            raise UserError(
                f"{path}, line {number}: must be two numbers, x and y, not {shortened(row.strip(), 40)!r}"
            ) from None
        points.append((x, y))
    return Drawing(checked(path, [np.array(points).reshape(-1, 2)]), f"a polygon of {len(points)} points")


def read_geojson(path: Path) -> Drawing:
    """All polygons of a GeoJSON geometry, feature or collection.

    Raises:
        UserError: it is no JSON, or holds no polygon.
    """
    try:
        whole = json.loads(text(path, BYTES))
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path}: is no JSON ({one_line(error)})") from None
    lines: list[Array] = []
    for polygon in _polygons(path, whole):
        if not isinstance(polygon, list):
            raise UserError(f"{path}: the coordinates of a polygon must be a list of rings")
        lines += [_ring(path, ring) for ring in polygon]
    if not lines:
        raise UserError(f"{path}: holds no Polygon or MultiPolygon")
    return Drawing(checked(path, lines), f"polygons of {counted(len(lines), 'ring')}")


def _polygons(path: Path, whole: Any) -> list[Any]:
    """Coordinates of every polygon, from whatever they are wrapped in."""
    found: list[Any] = []
    waiting = [whole]
    while waiting:
        node = waiting.pop()
        if not isinstance(node, dict):
            raise UserError(f"{path}: is no GeoJSON; a geometry must be an object with a type")
        kind, parts = node.get("type"), node.get("coordinates")
        if kind == "Polygon":
            found.append(parts)
        elif kind == "MultiPolygon" and isinstance(parts, list):
            found += parts
        elif kind == "Feature":
            waiting += [node["geometry"]] if node.get("geometry") is not None else []
        elif kind in ("FeatureCollection", "GeometryCollection"):
            inner = node.get("features" if kind == "FeatureCollection" else "geometries")
            waiting += inner if isinstance(inner, list) else []
    return found


def _ring(path: Path, ring: Any) -> Array:
    try:
        points = np.array([[float(x), float(y)] for x, y, *_ in ring])
    except (TypeError, ValueError, OverflowError):
        raise UserError(f"{path}: a ring must be a list of points [x, y]") from None
    return points.reshape(-1, 2)


def _number(part: str) -> bool:
    try:
        float(part)
    except ValueError:
        return False
    return True
