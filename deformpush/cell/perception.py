"""From the camera's picture to contour, centroid, orientation and mask."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import cv2
import numpy as np
from annotated_types import Interval

from deformpush.cell.camera import Camera
from deformpush.cell.mask import MaskGrid
from deformpush.cell.observation import FirstLook, Observation
from deformpush.cell.orientation import at_first, by_axis, by_registration, order_of_symmetry
from deformpush.cell.segmentation import PerceptionError as PerceptionError
from deformpush.cell.segmentation import Segmentation
from deformpush.mechanics.geometry import resample, rotation
from deformpush.mechanics.registration import HIGHEST
from deformpush.mechanics.rounding import METRES, rounded

Array = np.ndarray

ALIKE = 0.7
"""A blob of at least this share of the largest one's area may be the object as well (-)."""


@dataclass(frozen=True)
class Perception:
    """How a picture becomes an observation."""

    segmentation: Segmentation
    """What tells the object from the table."""
    M: Annotated[int, Interval(ge=16, le=1024)]
    """Contour points."""
    min_area: Annotated[float, Interval(gt=0, le=1)]
    """Blobs smaller than this are noise (m^2)."""
    compact_ratio: Annotated[float, Interval(ge=0.0, le=1.0)]
    """PCA is held to be ill-posed when the smaller standard deviation exceeds this share of the larger."""
    border_px: Annotated[int, Interval(ge=0, le=1000)]
    """An object this near the rim of the picture counts as leaving it (px)."""
    mask: MaskGrid
    angle: Literal["registration", "pca"] = "registration"
    """Theta by laying the first contour on the one seen, or by the principal axis, as in the paper."""
    symmetry: Annotated[int, Interval(ge=0, le=HIGHEST)] | None = None
    """Turns by 1 / symmetry of a circle look alike, 0: all do; None: found in the first picture."""

    def observe(self, image: Array, camera: Camera, previous: Observation | None = None) -> Observation:
        """Find the object in an RGB picture `(H, W, 3)` uint8.

        Raises:
            PerceptionError: nothing in it may be the object, two things may, or it touches the picture's rim.
        """
        contour = rounded(self.outline(self._blob(image, camera, previous), camera), METRES)
        c, compact = rounded(contour.mean(axis=0), METRES), False
        if previous is None:
            contour, theta, ratio = at_first(contour, c)
            compact = self.angle == "pca" and ratio > self.compact_ratio
            seen = Observation(contour, c, theta, self.shape(contour, c, theta), compact)
            order, follows = self._order(seen.body), self.angle == "registration"
            return replace(seen, first=FirstLook(seen.body, order, c, theta, follows))
        first = previous.reference
        if self.angle == "registration":
            contour, theta = by_registration(contour, c, first, previous.theta)
        else:
            contour, theta, compact = by_axis(contour, c, previous, self.compact_ratio)
        return Observation(contour, c, theta, self.shape(contour, c, theta), compact, first)

    def shape(self, contour: Array, c: Array, theta: float) -> Array:
        """Mask gamma `(H, W)` bool of a contour `(M, 2)` (m) with this centroid and orientation."""
        return self.mask.draw((contour - c) @ rotation(-theta).T)

    def outline(self, blob: Array, camera: Camera) -> Array:
        """Contour `(M, 2)` (m) of a blob, counter-clockwise, evenly spaced.

        Args:
            blob: the share of each pixel it covers `(H, W)`, bool or in [0, 1].
            camera: whose picture it is.
        """
        return resample(camera.to_m(_outline_px(blob)), self.M)

    def _blob(self, image: Array, camera: Camera, previous: Observation | None) -> Array:
        found = self.segmentation.mask(image).astype(np.uint8)
        count, labels, stats, centres = cv2.connectedComponentsWithStats(found, connectivity=8)
        areas = stats[1:, cv2.CC_STAT_AREA] / camera.scale**2
        large = 1 + np.flatnonzero(areas >= self.min_area)
        if count < 2 or not len(large):
            raise PerceptionError("no object in the picture: no blob that may be it is large enough")
        if previous is None:
            chosen = large[np.argmax(areas[large - 1])]
        else:  # the object is the blob nearest to where it was
            chosen = large[np.argmin(np.linalg.norm(camera.to_m(centres[large]) - previous.c, axis=1))]
        left, top, width, height = stats[chosen, :4]
        rim = min(left, top, image.shape[1] - left - width, image.shape[0] - top - height)
        if rim < self.border_px:
            raise PerceptionError("the object left the picture, or something reaches over its rim")
        alike = areas[large - 1] >= ALIKE * areas[chosen - 1]
        if previous is None and alike.sum() > 1:
            raise PerceptionError(f"{alike.sum()} objects of alike size in the picture; leave one in it")
        return labels == chosen

    def _order(self, body: Array) -> int:
        """Order of symmetry by which angles are told; PCA knows of none, as in the paper."""
        if self.symmetry is not None:
            return self.symmetry
        return order_of_symmetry(body, self.mask) if self.angle == "registration" else 1


def _outline_px(blob: Array, zoom: int = 4) -> Array:
    """Outer boundary of a blob in continuous pixel coordinates `(V, 2)`.

    cv2.findContours runs through pixel centres and so loses half a pixel all round; on a smoothly enlarged
    blob, thresholded half way, the loss is 1 / (2 zoom) of a pixel.
    """
    rows, cols = np.flatnonzero(blob.any(axis=1)), np.flatnonzero(blob.any(axis=0))
    pad = 3
    crop = np.pad(blob[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1], pad).astype(np.float32)
    fine = cv2.resize(
        cv2.GaussianBlur(crop, (3, 3), 0), None, fx=zoom, fy=zoom, interpolation=cv2.INTER_LINEAR
    )
    outlines, _ = cv2.findContours((fine >= 0.5).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=cv2.contourArea)[:, 0].astype(float)
    return (outline + 0.5) / zoom - 0.5 + (cols[0] - pad, rows[0] - pad)
