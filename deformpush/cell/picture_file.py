"""A picture from a file that may come from anywhere: a plain PNG or JPEG of a sane size, or a reason."""

import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

Array = np.ndarray

PNG, JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8"
"""How such files begin."""
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


def decode(data: bytes, most_px: int = MOST_PX, alpha: bool = False) -> Array:
    """RGB picture `(H, W, 3)` uint8 of a PNG or JPEG.

    Args:
        data: the file.
        most_px: a wider or higher picture is refused before memory is made for it.
        alpha: give a PNG's fourth channel too, if it has one: `(H, W, 4)`.

    Raises:
        ValueError: it is none, or too large.
    """
    import cv2  # not before it is needed: record/ asks for the sizes alone

    height, width = _size(data)
    if not 0 < min(height, width) <= max(height, width) <= most_px:
        raise ValueError(f"{width} x {height} pixels, 1 to {most_px} a side are allowed")
    as_it_is = alpha and not data.startswith(JPEG)
    with _silence(), suppress(cv2.error):
        found = cv2.imdecode(
            np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED if as_it_is else cv2.IMREAD_COLOR_RGB
        )
        if found is not None:
            return _channels(found) if as_it_is else np.asarray(found)
    raise ValueError("damaged, cannot be decoded")


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
    while data.startswith(JPEG) and at + 9 <= len(data) and data[at] == 0xFF:
        kind, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if kind == 0xFF:  # a fill byte
            at += 1
        elif 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):  # a frame begins
            return int.from_bytes(data[at + 5 : at + 7], "big"), int.from_bytes(data[at + 7 : at + 9], "big")
        else:
            at += 2 + length
    raise ValueError("no JPEG")


def _size(data: bytes) -> tuple[int, int]:
    """Height and width that a picture says it has."""
    if data.startswith(PNG) and data[12:16] == b"IHDR":
        return int.from_bytes(data[20:24], "big"), int.from_bytes(data[16:20], "big")
    if data.startswith(JPEG):
        return jpeg_size(data)
    raise ValueError("neither PNG nor JPEG")


def _channels(picture: Array) -> Array:
    """RGB, and a fourth channel if there is one, uint8, of what cv2 decodes as it is."""
    if picture.dtype == np.uint16:
        picture = (picture // 257).astype(np.uint8)
    if picture.ndim == 2:
        return np.repeat(picture[:, :, None], 3, axis=2)
    return np.ascontiguousarray(np.concatenate([picture[:, :, 2::-1], picture[:, :, 3:]], axis=2))


@contextmanager
def _silence() -> Iterator[None]:
    """Keep what the libraries of pictures print of a damaged one from standard error."""
    sys.stderr.flush()
    terminal = os.dup(2)
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
            yield
    finally:
        os.dup2(terminal, 2)
        os.close(terminal)
