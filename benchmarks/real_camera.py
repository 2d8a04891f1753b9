"""A camera with a lens, somewhere in space, and what it takes of the calibration sheet and of the table."""

from dataclasses import replace

import cv2
import numpy as np

from benchmarks.rendering import Shot
from deformpush.cell import calibration_sheet as sheet
from deformpush.cell.calibrated import CalibratedCamera

Array = np.ndarray

SIZE = (960, 720)
LENS = (-0.22, 0.06, 0.001, -0.0008, 0.0)
"""A wide lens: straight lines at the rim of the picture bend by 20 px."""
PAGE_BLUR = 4.0
"""Standard deviation (dots of the page): one line of sight then sees what the whole pixel would."""


def camera(
    place: tuple[float, float, float], target: tuple[float, float, float], roll: float = 0.0
) -> CalibratedCamera:
    """One at `place` (m) that looks at `target` (m), turned about its axis by `roll` (rad)."""
    axis = np.subtract(target, place) / np.linalg.norm(np.subtract(target, place))
    right = np.cross([0.0, 1.0, 0.1], axis)
    right /= np.linalg.norm(right)
    level = np.array([right, np.cross(axis, right), axis])
    turned = cv2.Rodrigues(np.array([0, 0, roll]))[0] @ level
    return CalibratedCamera(
        centre=(target[0], target[1]),
        field=0.5,
        distance=abs(place[2]),
        pixels=480,
        size=SIZE,
        focal=(788.0, 785.0),
        axis=(488.0, 353.0),
        distortion=LENS,
        turn=tuple(cv2.Rodrigues(turned)[0].ravel().tolist()),
        shift=tuple((-turned @ place).tolist()),
    )


def sheet_views(
    table: CalibratedCamera, count: int, square: float, at: tuple[float, float], shot: Shot, seed: int = 7
) -> list[Array]:
    """Pictures of the sheet: on the table with its middle at `at` (m), facing the camera, then held anyhow.

    Args:
        table: the camera, in the table's frame.
        count: pictures.
        square: side of a printed square (m).
        at: the sheet reads along the table's x axis there.
        shot: how they are taken.
        seed: of how the sheet is held.
    """
    rng = np.random.default_rng(seed)
    here = replace(table, shift=tuple(np.add(table.shift, table.rotation @ (*at, 0.0)).tolist()))
    views = [_view(here, square, mirrored=table.place[2] < 0)]
    for _ in range(count - 1):
        tilt, way, near = np.radians(rng.uniform(15, 40)), rng.uniform(0, 2 * np.pi), rng.uniform(0.4, 0.6)
        place = near * np.array([np.sin(tilt) * np.cos(way), np.sin(tilt) * np.sin(way), np.cos(tilt)])
        target = (*rng.uniform(-0.16, 0.16, 2), 0.0)
        views.append(_view(camera(tuple(place), target, rng.uniform(-np.pi, np.pi)), square, mirrored=False))
    return [replace(shot, seed=shot.seed + n).of(view) for n, view in enumerate(views)]


def _view(seen_from: CalibratedCamera, square: float, mirrored: bool) -> Array:
    """The sheet in the plane z = 0, its middle at the origin: `(H, W, 3)` in levels.

    Seen from below it is the other way up, as the camera reads it and the table's y axis does not turn.
    """
    page = cv2.GaussianBlur(sheet.page(), (0, 0), PAGE_BLUR)
    middle = np.array([sheet.PAGE_MM[0] / 2, 15 + sheet.ROWS * sheet.SQUARE_MM / 2]) * sheet.PX_PER_MM - 0.5
    cols, rows = np.meshgrid(*[np.arange(side, dtype=float) for side in SIZE])
    points = seen_from.from_raw(np.column_stack([cols.ravel(), rows.ravel()]))
    dots = points * (1, 1 if mirrored else -1) * sheet.SQUARE_MM * sheet.PX_PER_MM / square + middle
    x, y = dots.T.astype(np.float32).reshape(2, *cols.shape)
    grey = cv2.remap(page, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=170)
    return np.repeat(grey[..., None].astype(float), 3, axis=2)
