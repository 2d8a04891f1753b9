"""Renderings that look like photographs: soft edges, noise, uneven light, a table that may have a pattern."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from deformpush.cell.camera import Camera

Array = np.ndarray
Colour = tuple[float, float, float]

FINER = 4
"""Lines of sight per pixel, each way."""


@dataclass(frozen=True)
class Shot:
    """How a picture is taken."""

    blur: float = 0.0
    """Standard deviation (px)."""
    noise: float = 0.0
    """Standard deviation (levels of 255)."""
    uneven: float = 0.0
    """How much darker the corners are than the middle (-), and half of that from side to side."""
    light: Colour = (1.0, 1.0, 1.0)
    """Factors on red, green and blue."""
    seed: int = 0

    def of(self, scene: Array) -> Array:
        """The picture `(H, W, 3)` uint8 of a scene `(H, W, 3)` in levels."""
        height, width = scene.shape[:2]
        y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
        lit = (1 - self.uneven * (x**2 + y**2) / 2) * (1 + self.uneven * x / 4)
        seen = np.asarray(scene, float) * lit[..., None] * self.light
        if self.blur:
            seen = cv2.GaussianBlur(seen, (0, 0), self.blur)
        seen = seen + np.random.default_rng(self.seed).normal(0, self.noise, seen.shape)
        return np.clip(np.rint(seen), 0, 255).astype(np.uint8)


def scene(
    camera: Camera, things: Sequence[tuple[Array, Colour]], table: Array | Colour = (255, 255, 255)
) -> Array:
    """What lies on the table, without lens and light: `(H, W, 3)` in levels, later things over earlier ones.

    Args:
        camera: whose picture it is.
        things: outlines `(V, 2)` (m) and their colours (levels); a colour below 0 is a shadow, which leaves
            so much less of the light.
        table: its colour, or a picture of it `(H, W, 3)`.
    """
    n = camera.pixels
    shown = np.array(np.broadcast_to(np.asarray(table, float), (n, n, 3)))
    for outline, colour in things:
        share = cover(camera, outline)[..., None]
        shown *= 1 + share * np.minimum(colour, 0)
        if min(colour) >= 0:
            shown += share * (np.asarray(colour) - shown)
    return shown


def cover(camera: Camera, outline: Array) -> Array:
    """The share of each pixel `(H, W)` that an outline `(V, 2)` (m) covers."""
    n = camera.pixels
    px = camera.to_px(outline)
    left, top = np.clip(np.floor(px.min(axis=0)), 0, n - 1).astype(int)
    right, low = np.clip(np.ceil(px.max(axis=0)) + 1, 1, n).astype(int)
    middle = (np.arange(FINER) + 0.5) / FINER - 0.5
    x = np.add.outer(np.arange(left, right), middle).ravel()
    y = np.add.outer(np.arange(top, low), middle).ravel()[:, None]
    inside = np.zeros((len(y), len(x)), bool)
    for (x0, y0), (x1, y1) in zip(px, np.roll(px, -1, axis=0), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    share = np.zeros((n, n))
    share[top:low, left:right] = inside.reshape(low - top, FINER, right - left, FINER).mean(axis=(1, 3))
    return share


def grain(camera: Camera, colour: Colour, depth: float, seed: int = 0) -> Array:
    """A table with a pattern, like wood: `(H, W, 3)` in levels, whose brightness varies by +-`depth`."""
    n = camera.pixels
    stripes = np.random.default_rng(seed).normal(size=(n, n))
    stripes = cv2.GaussianBlur(stripes, (0, 0), sigmaX=40, sigmaY=2)
    return np.asarray((1 + depth * stripes / np.abs(stripes).max())[..., None] * colour)


def disc(x: float, y: float, radius: float) -> Array:
    """A round outline `(180, 2)` (m)."""
    angle = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    return np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])
