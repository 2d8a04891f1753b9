"""A picture from a file that may come from anywhere: a plain PNG or JPEG of a sane size, or a reason."""

import os
import stat
from pathlib import Path

import numpy as np

Array = np.ndarray

MOST_PX = 8192
"""Widest and highest picture that is decoded."""
MOST_BYTES = 64_000_000
"""Largest file that is read."""


def read(path: str | Path) -> Array:
    """RGB picture `(H, W, 3)` uint8 of a PNG or JPEG file, upright as its maker says.

    Raises:
        ValueError: it cannot be read, is no such file, or too large; one line without the path.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):  # a pipe would be waited for, a device has no end
            raise ValueError("no regular file")
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise ValueError(error.strerror or "cannot be read") from error
    if len(data) > MOST_BYTES:
        raise ValueError(f"larger than {MOST_BYTES / 1e6:g} MB")
    return decode(data)


def decode(data: bytes) -> Array:
    """RGB picture `(H, W, 3)` uint8 of a PNG or JPEG.

    Raises:
        ValueError: it is none, or too large; told before memory is made for it.
    """
    import cv2  # not before it is needed: record/ may want the sizes alone

    height, width = _size(data)
    if not 0 < min(height, width) <= max(height, width) <= MOST_PX:
        raise ValueError(f"{width} x {height} pixels, 1 to {MOST_PX} a side are allowed")
    try:
        found = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR_RGB)
    except cv2.error:
        found = None
    if found is None:
        raise ValueError("damaged, cannot be decoded")
    return np.asarray(found)


def png(picture: Array) -> bytes:
    """PNG of an RGB picture `(H, W, 3)` uint8."""
    import cv2

    return cv2.imencode(".png", picture[..., ::-1])[1].tobytes()


def shrunk(picture: Array, longest: int) -> Array:
    """A picture `(H, W, 3)` whose longer side has at most so many pixels."""
    import cv2

    scale = longest / max(picture.shape[:2])
    if scale >= 1:
        return picture
    high, wide = (max(1, round(scale * side)) for side in picture.shape[:2])
    return np.asarray(cv2.resize(picture, (wide, high), interpolation=cv2.INTER_AREA))


def jpeg_size(data: bytes) -> tuple[int, int]:
    """Height and width that a JPEG says it has.

    Raises:
        ValueError: it says none.
    """
    at = 2
    while data[:2] == b"\xff\xd8" and at + 9 <= len(data) and data[at] == 0xFF:
        kind, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):  # a frame begins
            return int.from_bytes(data[at + 5 : at + 7], "big"), int.from_bytes(data[at + 7 : at + 9], "big")
        at += 2 + length
    raise ValueError("no JPEG")


def _size(data: bytes) -> tuple[int, int]:
    """Height and width that a picture says it has."""
    if data[:8] == b"\x89PNG\r\n\x1a\n" and data[12:16] == b"IHDR":
        return int.from_bytes(data[20:24], "big"), int.from_bytes(data[16:20], "big")
    if data[:2] == b"\xff\xd8":
        return jpeg_size(data)
    raise ValueError("neither PNG nor JPEG")
