"""From the share of each pixel that something covers to the lines along its rim."""

import cv2
import numpy as np

Array = np.ndarray

LEAST = 0.01
"""Blobs, and holes, smaller than this are noise (of the largest blob)."""


def traced(coverage: Array) -> list[Array]:
    """Lines `(V, 2)` (px) where the coverage `(H, W)` is one half; x to the right, y up from the last row.

    The middle of a pixel lies half a pixel from its rims. Those around holes are among them.
    """
    field = np.pad(np.asarray(coverage, np.float32), 2)
    count, labels, stats, _ = cv2.connectedComponentsWithStats((field > 0.5).astype(np.uint8), connectivity=8)
    if count < 2:
        return []
    areas = stats[:, cv2.CC_STAT_AREA]
    areas[0] = 0
    kept = np.isin(labels, np.flatnonzero(areas >= LEAST * areas.max())).astype(np.uint8)
    field[cv2.dilate(kept, np.ones((3, 3), np.uint8)) == 0] = 0
    lines = level_lines(field, 0.5)
    lines = [line for line in lines if area(line) >= LEAST * areas.max()]
    return [(line - 1.5) * (1, -1) + (0, len(coverage)) for line in lines]


def level_lines(field: Array, level: float) -> list[Array]:
    """Lines `(V, 2)` along which a raster `(H, W)` has this value; its first pixel has its middle at 0, 0."""
    from contourpy import contour_generator

    found = contour_generator(z=field, line_type="Separate").lines(level)
    return [np.asarray(line, float) for line in found]


def area(line: Array) -> float:
    """Area within a closed line."""
    x, y = (line - line[0]).T
    return abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) / 2
