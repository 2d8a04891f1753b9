"""Closed lines of a DXF drawing."""

import io
import itertools
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from deformpush.errors import UserError
from deformpush.extras import library
from deformpush.outlines.drawing import MOST_POINTS, Array, Drawing, checked, content, counted, one_line

BYTES = 5_000_000
"""Largest file."""
MOST_ENTITIES = 5_000
UNITS = {1: "in", 4: "mm", 5: "cm", 6: "m"}
"""By number of $INSUNITS."""
DRAWN = {"LWPOLYLINE", "POLYLINE", "LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"}
"""What an outline is drawn with; texts, dimensions and hatches are passed over."""
FINE = 1 / 4000
"""Curves become lines that leave them by less (of the drawing's size)."""
GAP = 1 / 2000
"""Ends of lines nearer than this are one (of the drawing's size)."""


def read(path: Path) -> Drawing:
    """Every closed line of the model space, also those put together from several; $INSUNITS is the unit.

    Raises:
        UserError: it is no DXF, or too large, or the library is missing.
    """
    data = content(path, BYTES)
    if data[:22].startswith(b"AutoCAD Binary DXF"):
        raise UserError(f"{path}: is a binary DXF; save it as ASCII")
    ezdxf = library("ezdxf", "cad", str(path))
    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    try:
        document = ezdxf.read(io.StringIO(data.decode("utf-8", "replace").replace("\r\n", "\n")))
        paths = list(_paths(path, document))
        closed, loose = _flat(path, paths)
    except UserError:
        raise
    except (ezdxf.DXFError, ArithmeticError, LookupError, RecursionError, TypeError, ValueError) as error:
        raise UserError(f"{path}: cannot be read as DXF ({one_line(error)})") from None
    lines = closed + _joined(loose)
    unit = UNITS.get(int(document.header.get("$INSUNITS", 0)))
    return Drawing(checked(path, lines), f"DXF, {counted(len(lines), 'closed line')}", unit=unit)


def _paths(path: Path, document: Any) -> Iterator[Any]:
    """What is drawn, blocks taken apart."""
    from ezdxf import path as paths
    from ezdxf.disassemble import recursive_decompose

    wanted = (e for e in document.modelspace() if e.dxftype() in DRAWN | {"INSERT"})
    for count, entity in enumerate(recursive_decompose(wanted)):
        if count >= MOST_ENTITIES:
            raise UserError(f"{path}: draws more than {MOST_ENTITIES} entities; keep the outline alone")
        if entity.dxftype() in DRAWN:
            yield paths.make_path(entity)


def _flat(path: Path, paths: list[Any]) -> tuple[list[Array], list[Array]]:
    """Points along the closed and along the open paths."""
    ends = np.array([[*p.start.vec2, *p.end.vec2] for p in paths]).reshape(-1, 2)
    controls = [v.vec2 for p in paths for v in itertools.islice(p.control_vertices(), MOST_POINTS)]
    every = np.concatenate([ends, np.array([[v.x, v.y] for v in controls]).reshape(-1, 2)])
    size = float(np.ptp(every, axis=0).max()) if len(every) else 0.0
    if not (np.isfinite(size) and size > 0):
        raise UserError(f"{path}: holds no line in the model space that could be an outline")
    closed: list[Array] = []
    loose: list[Array] = []
    total = 0
    for one in paths:
        points = np.array([[v.x, v.y] for v in one.flattening(size * FINE, segments=4)])
        total += len(points)
        if total > MOST_POINTS:
            raise UserError(f"{path}: has more than {MOST_POINTS} points; simplify it")
        (closed if one.is_closed else loose).append(points)
    return closed, loose


def _joined(loose: list[Array]) -> list[Array]:
    """Open lines whose ends meet, put together to closed ones."""
    import shapely

    if not loose:
        return []
    size = float(np.ptp(np.concatenate(loose), axis=0).max())
    lines = [shapely.LineString(points) for points in loose if len(points) > 1]
    snapped = shapely.set_precision(shapely.MultiLineString(lines), size * GAP, mode="pointwise")
    faces = shapely.polygonize([shapely.node(snapped)])
    return [np.array(face.exterior.coords) for face in faces.geoms]
