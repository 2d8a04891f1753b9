"""Pictures: read within limits, their scale found, and the object in them as closed lines."""

import os
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from deformpush.errors import UserError
from deformpush.outlines import marker
from deformpush.outlines.drawing import Array, Drawing, checked, content
from deformpush.outlines.foreground import NotFoundError, by_alpha, by_background, by_two_levels
from deformpush.outlines.trace import traced

BYTES = 100_000_000
"""Largest file."""
MOST_PIXELS = 110_000_000
"""Of a picture, by its head: before anything is unpacked."""
WORKED_ON = 1600
"""A larger picture is made smaller, to this along its longer side (px)."""
NOISE = 1.6
"""Slits and whiskers narrower than that mean nothing in any picture (px)."""
PNG = b"\x89PNG\r\n\x1a\n"
JPEG = b"\xff\xd8\xff"


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
    data = content(path, BYTES)
    size = _png_size(data) if data.startswith(PNG) else _jpeg_size(data) if data.startswith(JPEG) else None
    if size is None:
        raise UserError(f"{path}: is no PNG or JPEG picture")
    width, height = size
    if min(size) < 16 or width * height > MOST_PIXELS:
        raise UserError(
            f"{path}: has {width} x {height} pixels; 16 a side to {MOST_PIXELS / 1e6:g} million in all "
            "are allowed"
        )
    flag = cv2.IMREAD_UNCHANGED if data.startswith(PNG) else cv2.IMREAD_COLOR
    image = None
    with _quiet():
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flag)
    if image is None:
        raise UserError(f"{path}: is a damaged picture")
    if image.dtype == np.uint16:
        image = (image // 257).astype(np.uint8)
    longer = max(image.shape[:2])
    shrunk = max(1.0, longer / WORKED_ON)
    if shrunk > 1:
        to = [max(1, round(n / shrunk)) for n in image.shape[1::-1]]
        image = cv2.resize(image, to, interpolation=cv2.INTER_AREA)
    if image.ndim == 2:
        return np.repeat(image[:, :, None], 3, axis=2), None, shrunk
    alpha = image[:, :, 3] if image.shape[2] == 4 else None
    return np.ascontiguousarray(image[:, :, 2::-1]), alpha, shrunk


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what the libraries of pictures print of a damaged one from standard error."""
    sys.stderr.flush()
    terminal = os.dup(2)
    try:
        with open(os.devnull, "wb") as nowhere, suppress(cv2.error):
            os.dup2(nowhere.fileno(), 2)
            yield
    finally:
        os.dup2(terminal, 2)
        os.close(terminal)


def _png_size(data: bytes) -> tuple[int, int] | None:
    """Width and height as the first chunk has them; None where it is not whole."""
    if len(data) < 33 or data[12:16] != b"IHDR" or not data.rstrip(b"\0").endswith(b"IEND\xaeB`\x82"):
        return None
    width, height = struct.unpack(">II", data[16:24])
    return width, height


def _jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Width and height as the start of the frame has them; None where there is none."""
    at = 2
    while at + 9 < len(data) and data[at] == 0xFF:
        code = data[at + 1]
        if code == 0xFF:  # a fill byte
            at += 1
        elif 0xC0 <= code <= 0xCF and code not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return None
