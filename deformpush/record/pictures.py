"""Pictures as JPEG: made, and read back one by one when they are asked for."""

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np

from deformpush.cell import picture_file
from deformpush.errors import UserError

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
    picture_file.jpeg_size(picture)
    return picture_file.decode(picture)
