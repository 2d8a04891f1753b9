"""Files of known outlines, and what the verb makes of them, without its command line."""

from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import shapely
import yaml

from deformpush.cli import object as verb
from deformpush.outlines.make import Made, Wanted, make
from deformpush.outlines.picture import Scale
from deformpush.outlines.read import read


@cache
def preset(name: str = "rect") -> Any:
    """What the verb needs of an object that is there."""
    return verb._preset(name)


def made(
    file: Path, metre: float | None = 1e-3, scale: Scale | None = None, length: float | None = None
) -> Made:
    """The object of a file; its unit is `metre` long."""
    data, sheet, _ = preset()
    drawing = read(file, scale or Scale())
    if drawing.mm_per_px is not None:
        metre = drawing.mm_per_px / 1e3
    wanted = Wanted("thing", sheet.thickness, None, None if length else metre, length)
    return make(drawing, wanted, data, ["a thing"], sheet.cell)


def polygon(one: Made) -> shapely.Polygon:
    """What stands in the YAML, about its centroid (m)."""
    return shapely.Polygon(yaml.safe_load(one.text)["outline"])


def centred(outline: np.ndarray) -> shapely.Polygon:
    """The same of a true outline (m)."""
    shape = shapely.Polygon(outline)
    return shapely.affinity.translate(shape, -shape.centroid.x, -shape.centroid.y)


def apart(a: shapely.Polygon, b: shapely.Polygon) -> float:
    """Hausdorff distance of two outlines."""
    return float(shapely.hausdorff_distance(a.exterior, b.exterior, densify=0.005))


def write(file: Path, image: np.ndarray) -> Path:
    """Save a picture, RGB or RGBA."""
    swapped = image[:, :, [2, 1, 0, 3][: image.shape[2]]] if image.ndim == 3 else image
    assert cv2.imwrite(str(file), np.ascontiguousarray(swapped))
    return file
