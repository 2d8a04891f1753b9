"""A picture of a mesh in one colour, drawn without an engine and without a driver, the same everywhere.

Corners are rounded to a fraction of a pixel; from there on all arithmetic is that of whole numbers, so a
picture has the same bits on every machine. A pixel belongs to the object where its middle lies in one of the
triangles that face the camera, their borders included.
"""

import numpy as np

from deformpush.cell.camera import Camera

Array = np.ndarray

FINE = 256
"""Corners are rounded to this fraction of a pixel."""


def draw(nodes: Array, triangles: Array, camera: Camera, rgb: tuple[float, float, float]) -> Array:
    """What the camera sees of a closed mesh on a white ground: RGB `(H, W, 3)` uint8.

    Args:
        nodes: `(N, 3)` (m), table frame.
        triangles: `(T, 3)` into the nodes, normals outward.
        camera: whose picture it is.
        rgb: colour of the mesh (0-1).
    """
    picture = np.full((camera.pixels, camera.pixels, 3), 255, np.uint8)
    rows, first, last = _spans(np.rint(camera.project(nodes) * FINE).astype(np.int64)[triangles])
    inside = (rows >= 0) & (rows < camera.pixels) & (last >= 0) & (first < camera.pixels) & (first <= last)
    if inside.any():
        rows, first, end = rows[inside], first[inside].clip(0), last[inside].clip(max=camera.pixels - 1) + 1
        top, left = rows.min(), first.min()
        window = picture[top : rows.max() + 1, left : end.max()]
        covered = _covered(rows - top, first - left, end - left, *window.shape[:2])
        window[covered] = np.rint(255 * np.array(rgb)).astype(np.uint8)
    return picture


def _spans(corners: Array) -> tuple[Array, Array, Array]:
    """Row, first and last column of every row of every triangle that faces the camera, each `(S,)`.

    Args:
        corners: `(T, 3, 2)`, in fractions of a pixel; x to the right, y down.
    """
    x, y = corners[..., 0], corners[..., 1]
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    # Facing: seen from below the normal points down, so the corners run clockwise in table and picture alike.
    corners = corners[area > 0]
    y = corners[..., 1]
    top, bottom = -(-y.min(axis=1) // FINE), y.max(axis=1) // FINE
    count = np.maximum(bottom - top + 1, 0)
    owner = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count) + top[owner]
    first, last = np.full(len(row), np.iinfo(np.int64).max), np.full(len(row), np.iinfo(np.int64).min)
    height = row * FINE
    for a, b in ((0, 1), (1, 2), (2, 0)):
        (ax, ay), (bx, by) = corners[owner, a].T, corners[owner, b].T
        rise = by - ay
        crossed = ((ay <= height) & (height <= by)) | ((by <= height) & (height <= ay))
        crossed &= rise != 0  # a level side ends where its neighbours begin
        # The column of the crossing is above / below, kept with a positive denominator.
        above, below = (ax * rise + (bx - ax) * (height - ay)) * np.sign(rise), np.abs(rise) * FINE
        below = np.where(crossed, below, 1)
        np.minimum(first, -(-above // below), out=first, where=crossed)
        np.maximum(last, above // below, out=last, where=crossed)
    return row, first, last


def _covered(rows: Array, first: Array, end: Array, height: int, width: int) -> Array:
    """Which pixels `(H, W)` lie in one of the spans: from column `first` up to, not including, `end`."""
    size = height * (width + 1)
    opened = np.bincount(rows * (width + 1) + first, minlength=size)
    closed = np.bincount(rows * (width + 1) + end, minlength=size)
    depth = np.cumsum((opened - closed).reshape(height, width + 1), axis=1)
    return np.asarray(depth[:, :-1] > 0)
