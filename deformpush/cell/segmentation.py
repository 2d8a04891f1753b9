"""Which pixels of a picture may be the object: those of its colours."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Protocol

import cv2
import numpy as np
from annotated_types import Interval, MinLen

Array = np.ndarray
Byte = Annotated[int, Interval(ge=0, le=255)]
Hue = Annotated[int, Interval(ge=0, le=179)]
Colour = tuple[Hue, Byte, Byte]
"""Hue as OpenCV counts it (0-179, half degrees), saturation and value (0-255)."""


class PerceptionError(RuntimeError):
    """The picture shows no object, or not all of it, or does not tell which it is."""

    key: ClassVar[str] = "object.start"
    """The setting that is most likely wrong where the first picture of a run is such a one."""


class SegmentationError(PerceptionError):
    """The picture as a whole does not tell the object from the table."""

    key = "contour.segmentation"


class Segmentation(Protocol):
    """What tells the object from the table."""

    def mask(self, picture: Array) -> Array:
        """Which pixels of an RGB picture `(H, W, 3)` uint8 may be the object: `(H, W)` bool.

        Raises:
            SegmentationError: the picture does not tell.
        """


@dataclass(frozen=True)
class HsvRanges:
    """What lies in one of some ranges of colour."""

    ranges: Annotated[tuple[tuple[Colour, Colour], ...], MinLen(1)]
    """Lowest and highest hue, saturation and value of each; from 170 to 10 a hue runs through red, 0."""

    def __post_init__(self) -> None:
        for low, high in self.ranges:
            if low[1] > high[1] or low[2] > high[2]:
                raise ValueError(f"ranges: saturation and value of {list(low)} must not exceed {list(high)}")

    def mask(self, picture: Array) -> Array:
        """See `Segmentation`; any picture will do."""
        hsv = cv2.cvtColor(picture, cv2.COLOR_RGB2HSV)
        found = np.zeros(picture.shape[:2], bool)
        for low, high in self.ranges:
            # A hue that runs through red is two ranges to OpenCV.
            for first, last in [(low[0], high[0])] if low[0] <= high[0] else [(low[0], 179), (0, high[0])]:
                inside = cv2.inRange(hsv, np.array((first, *low[1:])), np.array((last, *high[1:])))
                found |= inside.astype(bool)
        return found
