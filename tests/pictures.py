"""Pictures of polygons as the camera would take them, and shapes to draw."""

from itertools import pairwise

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.mechanics.geometry import rotation, signed_area

BLUE = (26, 64, 230)
RECT = np.array([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)])


def placed(shape: np.ndarray, x: float, y: float, degrees: float) -> np.ndarray:
    """A shape turned about the origin, then moved."""
    return shape @ rotation(np.radians(degrees)).T + (x, y)


def lobed(radius: float, depth: float, lobes: int) -> np.ndarray:
    """A disc with lobes: no principal direction, yet not round."""
    angle = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    r = radius * (1 + depth * np.cos(lobes * angle))
    return np.column_stack([r * np.cos(angle), r * np.sin(angle)])


def picture(camera: Camera, *polygons: np.ndarray, colour: tuple[int, int, int] = BLUE) -> np.ndarray:
    """White, and coloured where the middle of a pixel lies in a polygon (m)."""
    n = camera.pixels
    image = np.full((n, n, 3), 255, np.uint8)
    for polygon in polygons:
        px = camera.to_px(polygon)
        left, top = np.clip(np.floor(px.min(axis=0)).astype(int), 0, n)
        right, bottom = np.clip(np.ceil(px.max(axis=0)).astype(int) + 1, 0, n)
        x, y = np.meshgrid(np.arange(left, right), np.arange(top, bottom))
        inside = np.zeros(x.shape, bool)
        for (x0, y0), (x1, y1) in zip(px, np.roll(px, -1, axis=0), strict=True):
            if y0 != y1:
                inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        image[top:bottom, left:right][inside] = colour
    return image


def centroid(polygon: np.ndarray) -> np.ndarray:
    """Centroid of the area, by triangles about the first corner."""
    corner, parts = polygon[0], []
    for a, b in pairwise(polygon[1:]):
        parts.append((signed_area(np.array([corner, a, b])), (corner + a + b) / 3))
    areas = np.array([area for area, _ in parts])
    return areas @ np.array([middle for _, middle in parts]) / areas.sum()
