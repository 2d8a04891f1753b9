"""Which pixels of a picture may be the object: those that differ from the empty table."""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import cv2
import numpy as np
from annotated_types import Gt, Interval, Lt

from deformpush.cell import picture_file
from deformpush.cell.illumination import lit
from deformpush.cell.segmentation import SegmentationError

Array = np.ndarray

BLUR = 1.0
"""Standard deviation of the blur that noise is reduced by (px); a straight edge stays where it is."""
TINT_BLUR = 1.4
"""Of a further blur, before colours are compared (px)."""
EDGE = 5
"""From its rim this far inwards the object shows its full difference (px): more than lenses blur."""
NOISE = 6.0
"""Differences up to this multiple of what is usual on the table are noise."""
GREY = 0.02
"""A shadow changes red, green and blue by the same factor, to this accuracy (-)."""
FLAT = 0.18
"""Where the share of light that is left changes by more than this within 3 px, it is an edge (-)."""
THIN = 5
"""What is thinner is no shadow but a blurred edge, whose colours mix to grey (px)."""
MOST = 0.5
"""A larger share of the picture is no object on this table."""
RIM = 0.03
"""Share of the picture, at its rim, that tells the colour of a table which is not known empty."""


@dataclass(frozen=True)
class Background:
    """What differs from the table, be it in brightness or in colour; other light is allowed for."""

    empty: str | None
    """PNG or JPEG of the same table, empty, from the same camera; null: one colour, that of the rim."""
    contrast: Annotated[float, Interval(ge=1, le=255)]
    """Least difference that counts, in the channel where it is largest (levels, 0-255)."""
    shadow: Annotated[float, Gt(0), Lt(1)] | None
    """What keeps this share of the table's light, in its colour, is a shadow; null: there are none."""

    def __post_init__(self) -> None:
        _ = self._table

    def mask(self, picture: Array) -> Array:
        """See `deformpush.cell.segmentation.Segmentation`.

        Raises:
            SegmentationError: nothing stands out, nearly all of it does, or only what looks like a shadow.
        """
        table = self._like(picture)
        seen, ground = (_blurred(part, BLUR) for part in (picture, lit(table, picture)))
        differs = np.maximum.reduce(cv2.split(cv2.absdiff(seen, ground)))
        noise = float(np.median(differs[::2, ::2]))
        least = max(self.contrast, NOISE * noise)
        if (share := float(np.mean(differs > self.contrast))) > MOST:
            raise SegmentationError(
                f"{share:.0%} of the picture differs from the colour of its rim: a table with a pattern "
                "needs a picture of it, empty"
                if self.empty is None
                else f"{share:.0%} of the picture differs from the empty table: has the camera moved?"
            )
        found = differs > least
        if not found.any():
            raise SegmentationError(
                f"no object in the picture: nothing differs from the table by {least:.0f} levels of 255 or "
                f"more (at most {differs.max():.0f}); an object of the table's colour cannot be seen"
            )
        if self.shadow is not None:
            found = self._without_shadow(found, seen, ground)
        return _to_half_height(found, differs)

    @cached_property
    def _table(self) -> Array | None:
        if self.empty is None:
            return None
        try:
            return picture_file.read(self.empty)
        except ValueError as error:
            raise ValueError(f"empty = {self.empty}: {error}") from error

    def _like(self, picture: Array) -> Array:
        """The empty table as large as the picture."""
        if self._table is None:
            return np.broadcast_to(np.median(_rim(picture), axis=0), picture.shape)
        if self._table.shape != picture.shape:
            (high, wide), (h, w) = self._table.shape[:2], picture.shape[:2]
            raise SegmentationError(f"{self.empty} has {wide} x {high} pixels, the picture {w} x {h}")
        return self._table

    def _without_shadow(self, found: Array, seen: Array, ground: Array) -> Array:
        """What is left of a mask `(H, W)` without the pixels that are as the table is, but darker."""
        share = cv2.split((_blurred(seen, TINT_BLUR) + 1) / (_blurred(ground, TINT_BLUR) + 1))
        dimmed = np.minimum.reduce(share)
        spread = np.maximum.reduce(share) - dimmed
        even = spread < GREY + 2 * float(np.median(spread[::2, ::2]))
        dim = found & even & (dimmed >= self.shadow) & (dimmed < 1)
        # Its core, and what runs out beside that: where the object meets it, a shadow ends in thin tips.
        flat = cv2.morphologyEx(dimmed, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) < FLAT
        shadow = dim & (cv2.dilate(_opened(dim & flat, THIN).astype(np.uint8), _disc(2 * THIN + 1)) > 0)
        rest = found & ~shadow
        if rest.sum() < 0.1 * shadow.sum():
            raise SegmentationError(
                "no object in the picture but what looks like a shadow, of the table's colour and darker; "
                "if it is the object, shadow=null takes it"
            )
        # Its own rim is too pale or too mixed to be told; it is thin, and hangs together with nothing.
        crumbs = cv2.dilate(shadow.astype(np.uint8), _disc(THIN)) > 0
        return np.where(crumbs, _opened(rest, 3), rest)


def _rim(picture: Array) -> Array:
    """Pixels `(N, 3)` of the picture's rim."""
    inside = np.zeros(picture.shape[:2], bool)
    width = max(2, round(RIM * min(inside.shape)))
    inside[width:-width, width:-width] = True
    return picture[~inside]


def _blurred(picture: Array, sigma: float) -> Array:
    return cv2.GaussianBlur(np.asarray(picture, np.float32), (0, 0), sigma)


def _to_half_height(found: Array, differs: Array) -> Array:
    """Draw the rim of a mask in to where the difference is half of what it is beside it, inside.

    A blurred edge is that of the object where it has half of its height, whatever the threshold.
    """
    outlines, _ = cv2.findContours(found.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    solid = cv2.drawContours(np.zeros(found.shape, np.uint8), outlines, -1, 1, cv2.FILLED)
    around = _disc(2 * EDGE + 1)
    inner = cv2.erode(solid, around) > 0
    height = cv2.dilate(np.where(found, differs, 0).astype(np.float32), around)
    kept = found & (inner | (differs >= height / 2))
    # Where it shows two colours side by side, the paler one loses a notch to the other: fill it.
    return found & (cv2.morphologyEx(kept.astype(np.uint8), cv2.MORPH_CLOSE, around) > 0)


def _opened(mask: Array, width: int) -> Array:
    """A mask `(H, W)` without what is thinner than `width` (px)."""
    return cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, _disc(width)) > 0


def _disc(width: int) -> Array:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
