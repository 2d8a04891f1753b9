"""The silhouette of a solid, seen from above, along z."""

import io
import re
import warnings
from pathlib import Path

import cv2
import numpy as np

from deformpush.errors import UserError
from deformpush.extras import library
from deformpush.outlines.drawing import Drawing, checked, content, one_line
from deformpush.outlines.trace import traced

BYTES = 30_000_000
"""Largest file."""
MOST_FACES = 300_000
PIXELS = 2000
"""Of the picture of the silhouette, along its longer side: the outline is right to half of one."""
SHIFT = 4
"""Bits behind the point of a corner, in that picture."""


def read(path: Path) -> Drawing:
    """What the solid covers of the plane z = 0.

    Raises:
        UserError: it is no STL or OBJ, has too many faces, or the library is missing.
    """
    data = content(path, BYTES)
    kind = path.suffix.lower().lstrip(".")
    _refuse_a_lie(path, data, kind)
    trimesh = library("trimesh", "cad", str(path))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # From bytes: then no file that it names, such as a texture, is looked for.
            mesh = trimesh.load(
                io.BytesIO(data), file_type=kind, force="mesh", process=False, skip_materials=True
            )
            corners = np.asarray(mesh.triangles, float)
    except Exception as error:  # a reader of strangers' bytes may raise anything
        raise UserError(f"{path}: cannot be read as {kind.upper()} ({one_line(error)})") from None
    if not len(corners) or len(corners) > MOST_FACES:
        raise UserError(f"{path}: has {len(corners)} triangles, 1 to {MOST_FACES} are allowed")
    if not np.abs(corners).max() < 1e9:  # nan is not below
        raise UserError(f"{path}: a coordinate is not a finite number below 1e9")
    lo, hi = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    step = float((hi - lo)[:2].max()) / PIXELS
    if not step > 0:
        raise UserError(f"{path}: covers no area when seen along z")
    width, height = (np.ceil((hi - lo)[:2] / step).astype(int) + 3).tolist()
    px = (corners[:, :, :2] - lo[:2]) / step + 1
    shadow = np.zeros((height, width), np.uint8)
    for triangle in np.round((px - 0.5) * 2**SHIFT).astype(np.int32):
        cv2.fillConvexPoly(shadow, triangle, 255, shift=SHIFT)
    # The raster has y up already; traced() takes it for a picture and turns it over.
    lines = [line * step for line in traced(shadow[::-1] / 255.0)]
    said = f"{kind.upper()}, {len(corners)} triangles, seen along z, in which it measures {hi[2] - lo[2]:.4g}"
    return Drawing(checked(path, lines), said)


def _refuse_a_lie(path: Path, data: bytes, kind: str) -> None:
    """Refuse a file whose first bytes promise more than follows, or what is no text where text must be."""
    text = data.lstrip()[:5].lower() == b"solid"
    if kind == "obj" and not re.search(rb"^\s*v\s", data, re.MULTILINE):
        raise UserError(f"{path}: is no OBJ; it has no line of a vertex")
    if kind == "stl" and not text and (len(data) < 84 or len(data) - 84 != 50 * _count(data)):
        raise UserError(f"{path}: is no STL; it does not hold the triangles that its head promises")


def _count(data: bytes) -> int:
    return int.from_bytes(data[80:84], "little")
