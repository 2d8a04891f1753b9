"""Closed lines of an SVG drawing."""

import io
import logging
import re
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

from deformpush.errors import UserError, shortened
from deformpush.extras import library
from deformpush.outlines.drawing import Array, Drawing, checked, content, counted, one_line

BYTES = 5_000_000
"""Largest file."""
MOST_ELEMENTS = 20_000
MOST_DEPTH = 100
MOST_SEGMENTS = 10_000
MOST_LETTERS = 1_000_000
"""Of all paths together."""
CURVE, ARC = 32, 120
"""Points along each Bezier curve, and along each arc, which may go all the way round."""
PER_MM = 96 / 25.4
"""Pixels of a CSS millimetre."""
STATED = re.compile(r"\s*[\d.eE+-]+\s*(mm|cm|in|pt|pc|Q)\s*")


def read(path: Path) -> Drawing:
    """Every line of every visible shape; what lies open is closed.

    A width in millimetres, inches or the like states the unit. A width in pixels, or none, does not.

    Raises:
        UserError: it is no SVG, has entities or clones, or the library is missing.
    """
    data = content(path, BYTES)
    stated = _checked(path, data)
    svg = library("svgelements", "cad", str(path))
    logging.getLogger("svgelements").setLevel(logging.CRITICAL)
    try:
        drawing = svg.SVG.parse(io.BytesIO(data), reify=True, ppi=96.0)
        lines: list[Array] = []
        segments = 0
        for shape in drawing.elements(lambda e: isinstance(e, svg.Shape) and _visible(e)):
            for part in map(svg.Path, svg.Path(shape).as_subpaths()):
                segments += len(part)
                if segments > MOST_SEGMENTS:
                    raise UserError(f"{path}: has more than {MOST_SEGMENTS} segments; simplify it")
                lines.append(_points(svg, part))
    except UserError:
        raise
    except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError, AttributeError) as error:
        raise UserError(f"{path}: cannot be read as SVG ({one_line(error)})") from None
    scale = 1 / PER_MM if stated else 1.0
    lines = [line * (scale, -scale) for line in lines]
    return Drawing(checked(path, lines), f"SVG, {counted(len(lines), 'line')}", unit="mm" if stated else None)


def _points(svg: Any, path: Any) -> Array:
    """Points along a subpath, in pixels, y down."""
    parts = [np.empty((0, 2))]
    for segment in path:
        if isinstance(segment, svg.Move) or segment.start is None or segment.end is None:
            continue
        straight = isinstance(segment, svg.Line | svg.Close)
        count = 1 if straight else ARC if isinstance(segment, svg.Arc) else CURVE
        ends = [[segment.start.x, segment.start.y]]
        parts.append(np.array(ends if straight else segment.npoint(np.linspace(0, 1, count + 1))[:-1], float))
    return np.concatenate(parts)


def _visible(element: Any) -> bool:
    values = element.values
    hidden = values.get("display") == "none" or values.get("visibility") == "hidden"
    return not hidden and "defs" not in str(values.get("tag", ""))


def _checked(path: Path, data: bytes) -> bool:
    """Walk through the XML before anyone else does; whether the drawing states its size in a real unit.

    Raises:
        UserError: it is no XML, declares entities, clones what is drawn, or is too deep or too long.
    """
    parser = expat.ParserCreate()
    seen = {"depth": 0, "elements": 0, "letters": 0}
    root: dict[str, str] = {}

    def refuse(what: str) -> None:
        raise UserError(f"{path}: {what}")

    def entity(*_: object) -> None:
        refuse("declares XML entities, which are not followed; save it as a plain SVG")

    def begin(tag: str, attributes: dict[str, str]) -> None:
        tag = tag.rpartition(":")[2]
        seen["depth"] += 1
        seen["elements"] += 1
        if seen["elements"] == 1:
            root.update(attributes)
            if tag != "svg":
                refuse(f"is no SVG; its root is {shortened(tag, 30)}")
        if tag == "use":
            refuse("holds clones (use), which are not followed; unlink them before you save it")
        seen["letters"] += len(attributes.get("d", "")) + len(attributes.get("points", ""))
        if seen["letters"] > MOST_LETTERS:
            refuse(f"has paths of more than {MOST_LETTERS} letters; simplify it")
        if seen["elements"] > MOST_ELEMENTS or seen["depth"] > MOST_DEPTH:
            refuse(f"has more than {MOST_ELEMENTS} elements or {MOST_DEPTH} levels; draw the outline alone")

    def end(_: str) -> None:
        seen["depth"] -= 1

    parser.EntityDeclHandler = entity
    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise UserError(f"{path}: is no XML ({error})") from None
    except ValueError as error:
        if isinstance(error, UserError):
            raise
        raise UserError(f"{path}: is no XML ({one_line(error)})") from None
    return bool(STATED.fullmatch(root.get("width", "")))
