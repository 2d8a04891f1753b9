"""Photos of outlines as a camera would take them from above: blurred, unevenly lit, with noise."""

import cv2
import numpy as np

from deformpush.mechanics.geometry import rotation

Array = np.ndarray

FINE = 8
"""Drawn so many times larger."""


def photo(
    outline: Array,
    mm_per_px: float = 1.0,
    turn: float = 0.0,
    noise: float = 5.0,
    blur: float = 0.3,
    colours: tuple[tuple[int, int, int], tuple[int, int, int]] = ((196, 190, 182), (90, 110, 140)),
    seed: int = 0,
) -> tuple[Array, Array]:
    """A picture, RGB uint8, and the outline `(V, 2)` (mm, from its lower left corner, y up) that it shows.

    Args:
        outline: metres.
        mm_per_px: of the picture.
        turn: of the outline (rad).
        noise: scatter of every value (of 255).
        blur: of the lens, beside that of the pixels (px).
        colours: of the background and the object.
        seed: of the noise.
    """
    rng = np.random.default_rng(seed)
    mm = 1e3 * outline @ rotation(turn).T
    lo, hi = mm.min(axis=0), mm.max(axis=0)
    width, height = np.ceil((hi - lo + 60) / mm_per_px).astype(int).tolist()
    mm = mm - lo + 30 + rng.uniform(0, mm_per_px, 2)
    share = np.zeros((height * FINE, width * FINE), np.uint8)
    px = np.column_stack([mm[:, 0], height * mm_per_px - mm[:, 1]]) / mm_per_px * FINE - 0.5
    cv2.fillPoly(share, [np.round(px * 16).astype(np.int32)], 255, cv2.LINE_8, 4)
    cover = cv2.resize(share, (width, height), interpolation=cv2.INTER_AREA)[..., None] / 255.0
    image = (1 - cover) * np.array(colours[0]) + cover * np.array(colours[1])
    image = cv2.GaussianBlur(image, (0, 0), blur) if blur else image
    x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
    image *= (1 - 0.08 * x - 0.05 * y**2)[..., None]
    image += rng.normal(0, noise, image.shape)
    return np.clip(image, 0, 255).round().astype(np.uint8), mm
