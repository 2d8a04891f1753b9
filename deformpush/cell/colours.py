"""Ranges of colour that an object has and the table beside it has not."""

import cv2
import numpy as np

from deformpush.cell.segmentation import Colour

Array = np.ndarray
Ranges = tuple[tuple[Colour, Colour], ...]

GREY = 40
"""Below this saturation (0-255) a hue is chance."""
SHARE = 0.5
"""Percent of the object's pixels that may lie below a range, and above."""


def ranges(picture: Array, inside: Array, count: int, margin: int) -> Ranges:
    """So many ranges that hold the colours of the pixels `inside`.

    Args:
        picture: RGB `(H, W, 3)` uint8.
        inside: which pixels are the object, `(H, W)` bool.
        count: of ranges; colours are grouped by likeness.
        margin: by which saturation and value reach farther than what was found; hue by a third of it.
    """
    hsv = cv2.cvtColor(picture, cv2.COLOR_RGB2HSV)[inside].astype(int)
    angle = 2 * np.pi * hsv[:, 0] / 180
    places = np.column_stack([hsv[:, 1] * np.cos(angle), hsv[:, 1] * np.sin(angle), hsv[:, 2]])
    groups = _groups(places.astype(np.float32), count)
    return tuple(_range(hsv[groups == n], margin) for n in range(count) if np.any(groups == n))


def _groups(places: Array, count: int) -> Array:
    """Which of `count` groups each of points `(n, 3)` float32 belongs to: k-means, the same every time."""
    if count == 1:
        return np.zeros(len(places), int)
    centred = places - places.mean(axis=0)
    along = centred @ np.linalg.eigh(centred.T @ centred)[1][:, -1]
    first = np.searchsorted(np.quantile(along, np.arange(1, count) / count), along).astype(np.int32)
    enough = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.5)
    _, groups, _ = cv2.kmeans(places, count, first[:, None], enough, 1, cv2.KMEANS_USE_INITIAL_LABELS)
    return groups.ravel()


def _range(hsv: Array, margin: int) -> tuple[Colour, Colour]:
    """The range that holds colours `(n, 3)`, but for the strangest."""
    low, high = np.percentile(hsv[:, 1:], [SHARE, 100 - SHARE], axis=0).round().astype(int)
    (s0, v0), (s1, v1) = (low - margin).clip(0).tolist(), (high + margin).clip(max=255).tolist()
    strong = hsv[hsv[:, 1] >= GREY, 0]
    if 2 * len(strong) < len(hsv):
        return (0, s0, v0), (179, s1, v1)
    middle = np.angle(np.exp(2j * np.pi * strong / 180).mean()) * 90 / np.pi
    about = (strong - middle + 90) % 180 - 90
    first, last = np.percentile(about, [SHARE, 100 - SHARE]) + middle + np.array([-margin, margin]) / 3
    if last - first >= 179:
        return (0, s0, v0), (179, s1, v1)
    return (round(first) % 180, s0, v0), (round(last) % 180, s1, v1)
