"""Pictures: read within limits, their scale found, and the object in them as closed lines."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deformpush.cell import picture_file
from deformpush.errors import UserError
from deformpush.outlines import marker
from deformpush.outlines.drawing import Array, Drawing, checked, content
from deformpush.outlines.foreground import NotFoundError, by_alpha, by_background, by_two_levels
from deformpush.outlines.trace import traced

BYTES = 100_000_000
"""Largest file."""
LEAST_PX, MOST_PX = 16, 12_000
"""Along a side of a picture; larger ones are refused by their head, before anything is unpacked."""
WORKED_ON = 1600
"""A larger picture is made smaller, to this along its longer side (px)."""
NOISE = 1.6
"""Slits and whiskers narrower than that mean nothing in any picture (px)."""


@dataclass(frozen=True)
class Scale:
    """How the scale of a picture is told; at most one is not None."""

    mm_per_px: float | None = None
    marker_mm: float | None = None
    """Side of a printed ArUco marker."""
    charuco_mm: float | None = None
    """Side of a square of a printed ChArUco sheet."""


def read(path: Path, scale: Scale) -> Drawing:
    """The rim of what stands out in a picture.

    Raises:
        UserError: it is no picture, too large, or nothing in it can be told from the rest.
    """
    image, alpha, shrunk = _decoded(path)
    mm_per_px = None if scale.mm_per_px is None else scale.mm_per_px * shrunk
    taken = np.zeros(image.shape[:2], bool)
    notes = f"{image.shape[1]} x {image.shape[0]} px"
    if shrunk != 1:
        notes += f", made {shrunk:.3g} times smaller"
    if scale.marker_mm is not None or scale.charuco_mm is not None:
        try:
            found = marker.found(image, scale.marker_mm, scale.charuco_mm)
        except ValueError as error:
            raise UserError(f"{path}: {error}") from None
        image, mm_per_px, taken, alpha = found.image, found.mm_per_px, found.taken, None
        notes += f", {found.said}"
    try:
        way = by_alpha(alpha) or by_two_levels(image) or by_background(image, taken)
    except NotFoundError as error:
        raise UserError(f"{path}: {error}") from None
    lines = traced(way.coverage)
    if not lines:
        raise UserError(f"{path}: shows nothing but its background")
    height, width = image.shape[:2]
    outer = np.concatenate(lines)
    if not way.cropped and (outer.min() < 2 or np.any(outer.max(axis=0) > (width - 2, height - 2))):
        raise UserError(
            f"{path}: what stands out reaches the rim of the picture; leave room around the object, or cut "
            "other things off"
        )
    said = f"{notes}, {way.said}"
    noise = max(NOISE, 4 * way.blur)
    return Drawing(checked(path, lines), said, noise=noise, picture=image, mm_per_px=mm_per_px)


def _decoded(path: Path) -> tuple[Array, Array | None, float]:
    """RGB uint8, the alpha channel if it says anything, and how many times smaller it was made."""
    try:
        image = picture_file.decode(content(path, BYTES), MOST_PX, alpha=True)
    except ValueError as error:
        raise error if isinstance(error, UserError) else UserError(f"{path}: {error}") from error
    if min(image.shape[:2]) < LEAST_PX:
        raise UserError(f"{path}: {image.shape[1]} x {image.shape[0]} pixels, {LEAST_PX} a side are needed")
    times = max(1.0, max(image.shape[:2]) / WORKED_ON)
    if times > 1:
        image = picture_file.shrunk(image, WORKED_ON)
    return np.ascontiguousarray(image[:, :, :3]), image[:, :, 3] if image.shape[2] == 4 else None, times
