"""What a camera below the table would see of a mesh: its silhouette, with grey pixels along the edge."""

import cv2
import numpy as np

from deformpush.cell.camera import Camera

Array = np.ndarray

_FINER = 4  # lines of sight per pixel, each way
_SHIFT = 4  # fixed-point bits: corners are drawn to 1/16 of their distance


def silhouette(nodes: Array, triangles: Array, camera: Camera) -> Array:
    """The share of each pixel that a mesh covers, `(H, W)` float32 in [0, 1].

    Args:
        nodes: `(N, 3)` (m), table frame; the height is left out, as `camera` has one plane it looks at.
        triangles: `(T, 3)` into the nodes.
        camera: whose picture it is.
    """
    shares = np.zeros((camera.pixels, camera.pixels), np.float32)
    px = camera.to_px(nodes[:, :2])
    # Only the part of the picture where the mesh is: columns and rows, the last not included.
    first = np.clip(np.floor(px.min(axis=0)).astype(int), 0, camera.pixels)
    last = np.clip(np.ceil(px.max(axis=0)).astype(int) + 1, first, camera.pixels)
    width, height = last - first
    if not width * height:
        return shares
    fine = np.zeros((_FINER * height, _FINER * width), np.uint8)
    # Integer coordinates are the middles of pixels, in either picture.
    places = (px - first + 0.5) * _FINER - 0.5
    corners = np.round(places * 2**_SHIFT).astype(np.int32)
    for triangle in corners[triangles]:
        cv2.fillConvexPoly(fine, triangle, 255, shift=_SHIFT)
    grey = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)
    shares[first[1] : last[1], first[0] : last[0]] = grey.astype(np.float32) / 255
    return shares
