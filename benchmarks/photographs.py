"""Photographs that scikit-image and scikit-learn ship in their packages, and what is to be seen in some."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

Array = np.ndarray

FLOWER = [
    *((314, 84), (340, 87), (367, 98), (396, 109), (412, 120), (425, 141), (434, 167), (445, 207)),
    *((446, 229), (444, 250), (435, 276), (427, 291), (415, 314), (399, 332), (372, 344), (346, 353)),
    *((319, 360), (298, 361), (276, 357), (255, 350), (229, 338), (202, 319), (186, 298), (174, 266)),
    *((169, 229), (170, 202), (178, 175), (187, 154), (194, 138), (210, 117), (234, 106), (260, 96)),
    (287, 89),
]
"""Drawn by hand around the dahlia, to 2 px."""


@dataclass(frozen=True)
class Photograph:
    """One photograph, what is asked of it, and what is right."""

    name: str
    asked: str = "`see`"
    on: tuple[float, float] | None = None
    """A pixel on the object."""
    part: tuple[slice, slice] = (slice(None), slice(None))
    """Rows and columns that are cut out."""
    outline: Sequence[tuple[float, float]] | None = None
    """What a person drew around the object (px of the part)."""
    black: bool = False
    """Whether the object is what is black in it."""
    shown: bool = False

    def truth(self) -> Array | None:
        """The outline `(V, 2)` (px) of what is to be seen; None where nobody has drawn it."""
        if self.black:
            dark = (self.picture().max(axis=2) < 128).astype(np.uint8)
            outlines, _ = cv2.findContours(dark, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            return np.asarray(max(outlines, key=cv2.contourArea)[:, 0], float)
        return None if self.outline is None else np.array(self.outline, float)

    def picture(self) -> Array:
        """RGB `(H, W, 3)` uint8."""
        return np.ascontiguousarray(photograph(self.name.partition(",")[0])[self.part])


def ellipse(left: float, right: float, top: float, low: float) -> list[tuple[float, float]]:
    """An upright ellipse between these columns and rows."""
    angle = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    x = (left + right) / 2 + (right - left) / 2 * np.cos(angle)
    y = (top + low) / 2 + (low - top) / 2 * np.sin(angle)
    return list(zip(x.tolist(), y.tolist(), strict=True))


PHOTOGRAPHS = (
    Photograph("coins"),
    Photograph(
        "coins, one of them", part=(slice(5, 80), slice(300, 375)), outline=ellipse(4.7, 63.9, 10.3, 66.5)
    ),
    Photograph(
        "coins, another", part=(slice(160, 225), slice(180, 245)), outline=ellipse(8.5, 56.0, 9.5, 56.3)
    ),
    Photograph("horse", black=True),
    Photograph("flower"),
    Photograph("flower", asked="`see --on 330 180`", on=(330, 180), outline=FLOWER, shown=True),
    Photograph("coffee"),
    Photograph("coffee", asked="`see --on 180 320`", on=(180, 320)),
    Photograph("chelsea"),
    Photograph("rocket"),
    Photograph("china"),
)


def photograph(name: str) -> Array:
    """RGB `(H, W, 3)` uint8."""
    if name in ("flower", "china"):
        from sklearn.datasets import load_sample_image

        return np.asarray(load_sample_image(f"{name}.jpg"))
    import skimage.data

    found = np.asarray(getattr(skimage.data, name)())
    found = found.astype(np.uint8) * 255 if found.dtype == bool else found
    return np.repeat(found[..., None], 3, axis=2) if found.ndim == 2 else found[..., :3]


def texture(name: str, pixels: int) -> Array:
    """The middle of a photograph, as large as a picture of the camera: `(pixels, pixels, 3)` in levels."""
    found = photograph(name)
    side = min(found.shape[:2])
    top, left = ((length - side) // 2 for length in found.shape[:2])
    middle = found[top : top + side, left : left + side]
    return cv2.resize(middle, (pixels, pixels), interpolation=cv2.INTER_AREA).astype(float)
