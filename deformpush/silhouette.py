"""What a camera below the table would see of a mesh: its silhouette, pixel for pixel."""

import cv2
import numpy as np

from deformpush.camera import Camera

Array = np.ndarray

_SHIFT = 4  # fixed-point bits: corners are drawn to 1/16 pixel


def silhouette(nodes: Array, triangles: Array, camera: Camera) -> Array:
    """The pixels `(H, W)` bool that a mesh covers.

    Args:
        nodes: `(N, 3)` (m), table frame; the height is left out, as `camera` has one plane it looks at.
        triangles: `(T, 3)` into the nodes.
        camera: whose picture it is.
    """
    picture = np.zeros((camera.pixels, camera.pixels), np.uint8)
    corners = np.round(camera.to_px(nodes[:, :2]) * 2**_SHIFT).astype(np.int32)
    for triangle in corners[triangles]:
        cv2.fillConvexPoly(picture, triangle, 1, shift=_SHIFT)
    return picture.astype(bool)
