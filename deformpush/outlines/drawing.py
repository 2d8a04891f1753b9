"""What a file shows before anything is mended: closed lines, and how long their unit is."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deformpush.errors import UserError, shortened

Array = np.ndarray

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
"""By name of a unit: its length (m)."""
MOST_POINTS = 200_000
"""More than that in one file are not looked at."""
MOST_LINES = 5_000
"""The same for closed lines."""


@dataclass(frozen=True)
class Drawing:
    """Closed lines of a file."""

    lines: tuple[Array, ...]
    """Each `(V, 2)` in the file's unit, x to the right, y up; the first point need not be repeated."""
    said: str
    """What was read, for the user."""
    unit: str | None = None
    """Name of the unit that the file states, a key of `METRES`; None where it states none."""
    noise: float = 0.0
    """Of a picture: slits and whiskers narrower than this mean nothing (px)."""
    picture: Array | None = None
    """RGB `(H, W, 3)` uint8, of a picture, to draw over."""
    mm_per_px: float | None = None
    """Of a picture in which a marker was found."""


def content(path: Path, most: int) -> bytes:
    """The bytes of a regular file.

    Raises:
        UserError: there is none, it cannot be read, it is empty or larger than `most` bytes.
    """
    if not path.is_file():
        raise UserError(f"{path}: {'is no regular file' if path.exists() else 'no such file'}")
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror})") from error
    if not data:
        raise UserError(f"{path}: is empty")
    if len(data) > most:
        raise UserError(f"{path}: is larger than {most / 1e6:g} MB; make it smaller")
    return data


def text(path: Path, most: int) -> str:
    """The text of a file in UTF-8.

    Raises:
        UserError: as `content`, or it is no text.
    """
    try:
        return content(path, most).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UserError(f"{path}: is no text in UTF-8") from None


def counted(count: int, noun: str) -> str:
    """A number of things, in words."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def checked(path: Path, lines: list[Array]) -> tuple[Array, ...]:
    """Lines that can be an outline: of three points or more, all numbers finite.

    Raises:
        UserError: there is none, or there are too many, or a number is not finite.
    """
    kept = tuple(line for line in lines if len(line) >= 3)
    if not kept:
        raise UserError(f"{path}: holds no closed line of three points or more")
    count = sum(map(len, kept))
    if count > MOST_POINTS or len(kept) > MOST_LINES:
        raise UserError(
            f"{path}: holds {len(kept)} lines of {count} points in all; "
            f"{MOST_LINES} lines and {MOST_POINTS} points are allowed, simplify it"
        )
    if not all(np.abs(line).max() < 1e9 for line in kept):  # nan is not below
        raise UserError(f"{path}: a coordinate is not a finite number below 1e9")
    return kept


def one_line(error: Exception) -> str:
    """What a library says, short enough for a line."""
    return shortened(" ".join(str(error).split()), 80) or type(error).__name__
