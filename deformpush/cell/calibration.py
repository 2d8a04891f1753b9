"""From pictures of the calibration sheet to a camera: its lens from all, its place from the first."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np

from deformpush.cell import calibration_sheet as sheet
from deformpush.cell.calibrated import CalibratedCamera
from deformpush.mechanics.geometry import rotation

Array = np.ndarray

LEAST_VIEWS, LEAST_CORNERS = 4, 12
"""Fewer pictures, or fewer corners in one, tell no lens."""
MOST_PX = 1.0
"""A larger error (root mean square, px) is not that of a lens: a bent sheet, or two cameras."""
LEAST_TILT = 10.0
"""The sheet must lie this differently in two pictures (degrees), or they do not tell the focal length."""


class CalibrationError(ValueError):
    """The pictures do not tell what the camera is like."""


@dataclass(frozen=True)
class Calibration:
    """What was found, and how well it is known."""

    camera: CalibratedCamera
    used: int
    """Pictures that show enough of the sheet."""
    px: float
    """Root mean square distance of corners from where the lens puts them (px)."""
    table_mm: float
    """The same for the sheet on the table, measured there (mm)."""
    worst_mm: float
    """The largest of these distances (mm)."""
    rim_mm: float
    """Standard error that is expected at the worst place of the ideal picture's rim (mm)."""


def calibrate(
    pictures: Sequence[Array],
    square: float,
    at: tuple[float, float],
    degrees: float,
    side: Literal["above", "below"],
    rate: float,
) -> Calibration:
    """Calibrate a camera.

    Args:
        pictures: RGB `(H, W, 3)` uint8, all of one size; in the first the sheet lies on the table, facing the
            camera; in some of the others it is tilted.
        square: side of its squares (m).
        at: where its middle lies (m, table frame).
        degrees: turn of its reading direction from the table's x axis, counter-clockwise seen from above.
        side: of the table on which the camera stands.
        rate: pictures a second.

    Raises:
        CalibrationError: they do not tell.
    """
    size = _one_size(pictures)
    found = [sheet.find(picture) for picture in pictures]
    if len(found[0][0]) < LEAST_CORNERS:
        raise CalibrationError(
            f"the first picture, with the sheet on the table, shows {len(found[0][0])} of its corners, "
            f"{LEAST_CORNERS} are needed"
        )
    good = [view for view in found if len(view[0]) >= LEAST_CORNERS]
    if len(good) < LEAST_VIEWS:
        raise CalibrationError(
            f"{len(good)} of {len(pictures)} pictures show {LEAST_CORNERS} corners of the sheet or more, "
            f"{LEAST_VIEWS} are needed, some of them with the sheet tilted"
        )
    on_sheet = sheet.corners(square) * (1, 1 if side == "above" else -1)
    on_table = (on_sheet @ rotation(np.radians(degrees)).T + at)[found[0][0]]
    px, matrix, lens = _lens(good, square, size)
    camera = _ideal(_placed(size, matrix, lens, on_table, found[0][1], rate))
    off = np.linalg.norm(camera.from_raw(found[0][1]) - on_table, axis=1)
    rim = camera.from_raw(camera.to_raw(_rim(camera)))
    n, others = len(good), []
    for left in range(n):  # the same without one of the pictures, and without some corners of the first
        _, matrix, lens = _lens(good[:left] + good[left + 1 :], square, size)
        kept = np.arange(len(on_table)) % n != left
        other = _placed(size, matrix, lens, on_table[kept], found[0][1][kept], rate)
        others.append(other.from_raw(camera.to_raw(_rim(camera))) - rim)
    variance = (n - 1) / n * np.sum(np.square(others), axis=(0, 2))  # the jackknife's
    return Calibration(
        camera=camera,
        used=n,
        px=px,
        table_mm=float(1e3 * np.sqrt(np.mean(off**2))),
        worst_mm=float(1e3 * off.max()),
        rim_mm=float(1e3 * np.sqrt(variance.max())),
    )


def _one_size(pictures: Sequence[Array]) -> tuple[int, int]:
    """Width and height of all pictures."""
    sizes = list(dict.fromkeys((picture.shape[1], picture.shape[0]) for picture in pictures))
    if len(sizes) != 1:
        told = ", ".join(f"{wide} x {high}" for wide, high in sizes) or "none"
        raise CalibrationError(f"the pictures must be of one size (px), these are: {told}")
    return sizes[0]


def _lens(
    views: Sequence[tuple[Array, Array]], square: float, size: tuple[int, int]
) -> tuple[float, Array, Array]:
    """Error (px), camera matrix and distortion that fit all views of the sheet."""
    flat = np.column_stack([sheet.corners(square), np.zeros(len(sheet.corners(square)))]).astype(np.float32)
    try:
        px, matrix, lens, turns, _ = cv2.calibrateCamera(
            [flat[numbers] for numbers, _ in views],
            [seen.astype(np.float32) for _, seen in views],
            size,
            None,
            None,
            flags=cv2.CALIB_FIX_K3,
        )
    except cv2.error as error:
        raise CalibrationError("no lens takes such pictures of the sheet") from error
    if not np.isfinite(px) or px > MOST_PX:
        raise CalibrationError(
            f"no lens fits the pictures: {px:.1f} px off; is the sheet flat, and one camera used?"
        )
    normals = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    tilt = float(np.degrees(np.arccos(np.clip((normals @ normals.T).min(), -1, 1))))
    if tilt < LEAST_TILT:
        raise CalibrationError(
            f"the sheet is tilted by {tilt:.0f} degrees between pictures at most: tilt it by 20 to 45 "
            "degrees, in several directions, in some of them"
        )
    return float(px), np.asarray(matrix), np.asarray(lens).ravel()[:5]


def _placed(
    size: tuple[int, int], matrix: Array, lens: Array, on_table: Array, seen: Array, rate: float
) -> CalibratedCamera:
    """The camera whose picture shows points `(n, 2)` (m) of the table at pixels `seen` `(n, 2)`."""
    high = np.column_stack([on_table, np.zeros(len(on_table))])
    _, turn, shift = cv2.solvePnP(high, seen, matrix, lens)
    away = abs(float((cv2.Rodrigues(turn)[0].T @ shift)[2, 0]))
    if not 0.01 <= away <= 10:
        raise CalibrationError(f"the camera would stand {away:.3g} m from the table; is --square right?")
    k1, k2, p1, p2, k3 = map(float, lens)
    (a, b, c), (x, y, z) = turn.ravel().tolist(), shift.ravel().tolist()
    return CalibratedCamera(
        centre=(0.0, 0.0),
        field=1.0,
        distance=away,
        pixels=64,
        rate=rate,
        size=size,
        focal=(float(matrix[0, 0]), float(matrix[1, 1])),
        axis=(float(matrix[0, 2]), float(matrix[1, 2])),
        distortion=(k1, k2, p1, p2, k3),
        turn=(a, b, c),
        shift=(x, y, z),
    )


def _ideal(camera: CalibratedCamera) -> CalibratedCamera:
    """The camera, with the largest square of the table that is wholly in its picture, at its own scale."""
    last = np.array(camera.size) - 1.0
    middle = np.round(camera.from_raw(last[None] / 2)[0], 3)
    step = np.array([[1e-3, 0.0], [0.0, 1e-3]])
    scale = 1e3 * np.linalg.norm(camera.to_raw(middle + step) - camera.to_raw(middle[None]), axis=1).mean()
    low, high = 0, 10_000
    while high - low > 1:  # millimetres of the field
        tried = (low + high) // 2
        rim = _rim(replace(camera, centre=tuple(middle), field=tried / 1e3))
        px = camera.to_raw(rim)
        inside = bool((px >= 0).all() and (px <= last).all())
        # A lens formula folds far outside of the picture, and may show there what is elsewhere.
        seen = inside and float(np.abs(camera.from_raw(px) - rim).max()) < 1e-4
        low, high = (tried, high) if seen else (low, tried)
    if low < 10:
        raise CalibrationError("the middle of the first picture does not show the table")
    pixels = int(np.clip(round(scale * low / 1e3), 64, 2048))
    return replace(camera, centre=tuple(middle.tolist()), field=low / 1e3, pixels=pixels)


def _rim(camera: CalibratedCamera) -> Array:
    """Table points `(N, 2)` (m) along the rim of the ideal picture."""
    along, end = np.linspace(-1, 1, 33), np.ones(33)
    sides = [np.column_stack(pair) for pair in ((along, end), (along, -end), (end, along), (-end, along))]
    return np.concatenate(sides) * camera.field / 2 + camera.centre
