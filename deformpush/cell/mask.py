"""The raster on which shapes are compared."""

from dataclasses import dataclass
from typing import Annotated

import cv2
import numpy as np
from annotated_types import Interval

from deformpush.mechanics.rounding import METRES, rounded

Array = np.ndarray

MOST_PIXELS = 4096
"""Along a side of the raster of masks."""


@dataclass(frozen=True)
class MaskGrid:
    """The raster on which masks are compared: square, origin in its middle."""

    size: Annotated[float, Interval(ge=0.01, le=10)]
    """Side length (m)."""
    pixel: Annotated[float, Interval(ge=1e-4, le=0.1)]
    """Pixel size (m)."""

    def __post_init__(self) -> None:
        if not 1 <= round(self.size / self.pixel) <= MOST_PIXELS:
            raise ValueError(
                f"pixel: {self.pixel:g} m makes {self.size / self.pixel:.3g} pixels of a side of "
                f"{self.size:g} m, 1 to {MOST_PIXELS} are allowed"
            )

    def draw(self, polygon: Array) -> Array:
        """Binary mask of a polygon `(V, 2)` in metres, x to the right, y up."""
        n = round(self.size / self.pixel)
        px = rounded(polygon, METRES) / self.pixel * (1, -1) + (n - 1) / 2
        mask = np.zeros((n, n), np.uint8)
        shift = 4  # fixed-point bits: polygon corners are drawn to 1/16 pixel
        cv2.fillPoly(mask, [np.round(px * 2**shift).astype(np.int32)], 1, shift=shift)
        return mask.astype(bool)
