"""The object in a single picture: by its difference from the table, by its colours, by a place on it."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from deformpush.cell import colours
from deformpush.cell.background import Background
from deformpush.cell.camera import Camera
from deformpush.cell.observation import Observation
from deformpush.cell.perception import Perception
from deformpush.cell.segmentation import HsvRanges, PerceptionError
from deformpush.mechanics.geometry import rotation, signed_area

Array = np.ndarray

INSET, BESIDE = 3, (4, 15)
"""So far from the outline, inwards, the object's colours are taken, and outwards those of the table (px)."""
TRIED = [(count, margin) for count in (1, 2, 3) for margin in (100, 60, 35, 20, 10)]
"""How many ranges of colour are tried, and how wide."""
PLACE = 0.02
"""Radius of the place pointed at, whose colours are taken, as a share of the picture's shorter side."""
MARGINS = range(10, 130, 10)
"""Widths of ranges that are tried about the colours of a place."""
STEADY = 0.01
"""Wider ranges that change the area by less than this share show the same thing."""
GAIN = 0.003
"""More or narrower ranges must agree better by this (-)."""


@dataclass(frozen=True)
class Sight:
    """What is seen in a picture, and by what."""

    perception: Perception
    seen: Observation
    inside: Array
    """Pixels that are surely object, `(H, W)` bool."""
    contrast: float
    """Between object and table, in the channel where it is largest (levels of 255)."""
    noise: float
    """Standard deviation on the table beside the object, in the channel where it is largest (levels)."""
    agreement: float = 1.0
    """Area in which this sight and that by difference agree, over the area of both (-)."""

    @property
    def area(self) -> float:
        """Of what is seen (m^2)."""
        return signed_area(self.seen.contour)

    @property
    def extent(self) -> tuple[float, float]:
        """Length along its axis, and width across (m)."""
        along, across = np.ptp((self.seen.contour - self.seen.c) @ rotation(self.seen.theta), axis=0)
        return float(along), float(across)


def by_difference(picture: Array, camera: Camera, eye: Perception, table: Background) -> Sight:
    """What differs from the table.

    Args:
        picture: RGB `(H, W, 3)` uint8, as `camera` has it.
        camera: its scale.
        eye: all but how the object is told from the table.
        table: what it looks like empty.

    Raises:
        PerceptionError: nothing that could be the object, or not all of it, or two such things.
    """
    eye = replace(eye, segmentation=table)
    return _described(picture, camera, eye, eye.observe(picture, camera))


def by_colour(picture: Array, camera: Camera, found: Sight) -> Sight:
    """What has the colours of what was found; the ranges are those that agree best with it."""
    best = replace(found, agreement=0.0)
    for count, margin in TRIED:
        ranges = HsvRanges(colours.ranges(picture, found.inside, count, margin))
        eye = replace(found.perception, segmentation=ranges)
        try:
            seen = eye.observe(picture, camera)
        except PerceptionError:
            continue
        one, other = (_filled(picture, camera, sight.contour) for sight in (seen, found.seen))
        agreement = float((one & other).sum() / (one | other).sum())
        if agreement > best.agreement + GAIN:
            best = replace(found, perception=eye, seen=seen, agreement=agreement)
    return best


def by_place(picture: Array, camera: Camera, eye: Perception, place: tuple[float, float]) -> Sight:
    """What has the colours of a place on it, in the widest ranges that still show the same.

    Args:
        picture: as in `by_difference`.
        camera: as there.
        eye: as there.
        place: column and row of a pixel on the object.

    Raises:
        PerceptionError: no such ranges show an object there.
    """
    column, row = round(place[0]), round(place[1])
    radius = max(2, round(PLACE * min(picture.shape[:2])))
    disc = cv2.circle(np.zeros(picture.shape[:2], np.uint8), (column, row), radius, 1, cv2.FILLED) > 0
    found: list[tuple[Perception, Observation, float]] = []
    why = "its colours are everywhere"
    for margin in MARGINS:
        here = replace(eye, segmentation=HsvRanges(colours.ranges(picture, disc, 2, margin)))
        try:
            seen = here.observe(picture, camera)
        except PerceptionError as problem:
            why = str(problem)
            continue
        solid = _filled(picture, camera, seen.contour)
        if solid[row, column]:
            found.append((here, seen, float(solid.sum())))
    if len(found) < 2:
        raise PerceptionError(f"its colours at ({column}, {row}) do not tell the object: {why}")
    change = np.abs(np.diff(np.log([area for *_, area in found])))
    steady = np.flatnonzero(change < max(STEADY, change.min() + 1e-9))
    best, seen, _ = found[int(steady[-1]) + 1]
    return _described(picture, camera, best, seen)


def _described(picture: Array, camera: Camera, eye: Perception, seen: Observation) -> Sight:
    """What is seen, with how it stands out."""
    inside, around = _parts(picture, camera, eye, seen)
    object_, ground = (np.median(picture[part], axis=0) for part in (inside, around))
    noise = 1.4826 * np.median(np.abs(picture[around] - ground), axis=0).max()
    return Sight(eye, seen, inside, float(np.abs(object_ - ground).max()), float(noise))


def _parts(picture: Array, camera: Camera, eye: Perception, seen: Observation) -> tuple[Array, Array]:
    """Which pixels are surely object, and which surely table beside it: `(H, W)` bool each."""
    solid = _filled(picture, camera, seen.contour).astype(np.uint8)
    blob = eye.segmentation.mask(picture) & (solid > 0)  # an outline of few points smooths gaps over
    inside = cv2.erode(blob.astype(np.uint8), np.ones((2 * INSET + 1,) * 2, np.uint8)) > 0
    near, far = (cv2.dilate(solid, np.ones((2 * width + 1,) * 2, np.uint8)) > 0 for width in BESIDE)
    around = far & ~near
    return (inside if inside.any() else blob), (around if around.any() else solid == 0)


def _filled(picture: Array, camera: Camera, contour: Array) -> Array:
    """Which pixels `(H, W)` lie in a contour `(M, 2)` (m)."""
    corners = np.rint(camera.to_px(contour) * 16).astype(np.int32)
    return cv2.fillPoly(np.zeros(picture.shape[:2], np.uint8), [corners], 1, shift=4) > 0
