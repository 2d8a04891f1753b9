"""The empty table under the light of another picture: brighter here, darker there, of another white."""

import cv2
import numpy as np

Array = np.ndarray

CELLS = 64
"""Light is compared in so many cells along the longer side of the picture."""
FINEST = 0.004
"""Ratios of light that differ by less are one (-): a level of 255."""


def lit(table: Array, picture: Array) -> Array:
    """A table `(H, W, 3)` as it would look in the light of a picture of it `(H, W, 3)`: float32.

    The light changes slowly over the picture: each channel by a polynomial of second degree, fitted to where
    the picture shows table. What does not follow it, the object, is left out step by step.
    """
    height, width = picture.shape[:2]
    scale = min(1.0, CELLS / max(height, width))
    size = max(8, round(scale * width)), max(8, round(scale * height))
    small, empty = (
        cv2.resize(np.asarray(part, np.float32), size, interpolation=cv2.INTER_AREA) + 1
        for part in (picture, table)
    )
    ratio = (small / empty).astype(float)
    rows, cols = np.mgrid[-1 : 1 : size[1] * 1j, -1 : 1 : size[0] * 1j]
    powers = np.stack([np.ones_like(rows), cols, rows, cols * rows, cols**2, rows**2], axis=-1)
    rim = (np.abs(rows) == 1) | (np.abs(cols) == 1)
    light = np.broadcast_to(np.median(ratio[rim], axis=0), ratio.shape)
    for terms in (1, 3, 3, 6, 6, 6):
        off = np.abs(ratio - light).max(axis=2)
        near = off <= max(3 * 1.5 * float(np.median(off)), FINEST)
        known = powers[..., :terms]
        light = known @ np.linalg.lstsq(known[near], ratio[near], rcond=None)[0]
    whole = cv2.resize(light.astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray((np.asarray(table, np.float32) + 1) * whole - 1)
