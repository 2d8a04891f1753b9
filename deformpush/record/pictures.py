"""Pictures as JPEG: made, and read back one by one when they are asked for."""

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np

from deformpush.errors import UserError

MOST_PX = 8192
"""Widest and highest picture that is decoded."""

Array = np.ndarray


class Views(Sequence[Array]):
    """RGB images `(H, W, 3)`, decoded when they are asked for: thousands of them fill a memory."""

    def __init__(self, pictures: Sequence[bytes], where: str) -> None:
        """`where` they come from, for messages."""
        self._pictures, self._where = pictures, where

    def __len__(self) -> int:
        return len(self._pictures)

    @overload
    def __getitem__(self, k: int) -> Array: ...
    @overload
    def __getitem__(self, k: slice) -> "Views": ...
    def __getitem__(self, k: int | slice) -> "Array | Views":
        """The image after push k.

        Raises:
            UserError: it is damaged.
        """
        if isinstance(k, slice):
            return Views(self._pictures[k], self._where)
        try:
            return decode(self._pictures[k])
        except ValueError as error:
            raise UserError(f"{self._where}: picture {k} is damaged ({error})") from error

    def __iter__(self) -> Iterator[Array]:
        return (self[k] for k in range(len(self)))


def encode(image: Array, width: int, quality: int) -> bytes:
    """JPEG of an RGB image `(H, W, 3)`, scaled down to at most `width` pixels."""
    import cv2

    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    scale = width / bgr.shape[1]
    if scale < 1:
        bgr = cv2.resize(bgr, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return data.tobytes()


def decode(picture: bytes) -> Array:
    """RGB image `(H, W, 3)` of a JPEG.

    Raises:
        ValueError: it is none, or larger than any camera makes.
    """
    import cv2

    height, width = _size(picture)
    if not 0 < max(height, width) <= MOST_PX:
        raise ValueError(f"{width} x {height} pixels")
    found = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR_RGB)
    if found is None:
        raise ValueError("not to be decoded")
    return np.asarray(found)


def _size(picture: bytes) -> tuple[int, int]:
    """Height and width that a JPEG says it has, before memory is made for it.

    Raises:
        ValueError: it says none.
    """
    at = 2
    while picture[:2] == b"\xff\xd8" and at + 9 <= len(picture) and picture[at] == 0xFF:
        kind, length = picture[at + 1], int.from_bytes(picture[at + 2 : at + 4], "big")
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):  # a frame begins
            return int.from_bytes(picture[at + 5 : at + 7], "big"), int.from_bytes(
                picture[at + 7 : at + 9], "big"
            )
        at += 2 + length
    raise ValueError("no JPEG")
