"""The scale of a picture, from a printed ArUco marker or a ChArUco sheet that lies beside the object.

One marker gives a scale and no more: the picture must be taken from straight above. On a sheet the middles of
the markers lie on a lattice, whatever its size: each is two squares from the next in its row, and one square
to the side and one up from the next in a diagonal. From them the picture is straightened out.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from deformpush.outlines.drawing import counted
from deformpush.outlines.trace import area, level_lines

Array = np.ndarray

DICTIONARIES = ("4X4_1000", "5X5_1000", "6X6_1000", "7X7_1000", "ARUCO_ORIGINAL", "APRILTAG_36h11")
TILTED = 0.025
"""Sides of a marker that differ by more show a picture taken at a slant."""
FEWEST = 6
"""Markers that must be seen of a sheet."""
WIDEST = 2000
"""Of a picture that is straightened out (px)."""


@dataclass(frozen=True)
class Marked:
    """A picture with its scale."""

    image: Array
    """RGB `(H, W, 3)` uint8, straightened out where a sheet shows how."""
    mm_per_px: float
    taken: Array
    """Pixels of markers and the paper next to them `(H, W)` bool."""
    said: str


def found(image: Array, marker_mm: float | None, charuco_mm: float | None) -> Marked:
    """Look for markers, and take the scale from them.

    Raises:
        ValueError: there is none, too few for a sheet, or the picture is tilted.
    """
    corners = _corners(image)
    if marker_mm is not None:
        return _by_marker(image, corners, marker_mm)
    assert charuco_mm is not None
    return _by_sheet(image, corners, charuco_mm)


def _corners(image: Array) -> Array:
    """Corners (px) of the markers of the dictionary that finds most, `(n, 4, 2)`."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    best = np.empty((0, 4, 2))
    for name in DICTIONARIES:
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))
        seen, _, _ = cv2.aruco.ArucoDetector(known, settings).detectMarkers(grey)
        if len(seen) > len(best):
            best = np.array(seen, float).reshape(-1, 4, 2)
    if not len(best):
        raise ValueError("shows no ArUco marker; it must be whole, sharp, and have a white margin")
    return best


def _by_marker(image: Array, corners: Array, side_mm: float) -> Marked:
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    unequal = float((sides.max(axis=1) / sides.min(axis=1)).min() - 1)
    if unequal > TILTED:
        raise ValueError(
            f"the sides of its marker differ by {unequal:.0%}: it was taken at a slant; take it from "
            "straight above, or use a ChArUco sheet"
        )
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    side = float(np.median([_side(grey, quad) for quad in corners]))
    said = f"{counted(len(corners), 'marker')} of {side:.1f} px"
    return Marked(image, side_mm / side, _around(corners, image), said)


def _side(grey: Array, quad: Array) -> float:
    """Side of a marker (px): of the line half-way between its black and the white around it.

    Its corners are found less well than that: a blurred one lies too far inside.
    """
    rough = float(np.sqrt(area(quad)))
    margin = 0.2 * rough
    x0, y0 = np.maximum(np.floor(quad.min(axis=0) - margin), 0).astype(int)
    x1, y1 = np.ceil(quad.max(axis=0) + margin + 1).astype(int)
    crop = grey[y0:y1, x0:x1].astype(np.float32)
    dark, bright = np.percentile(crop, (5, 95))
    sides = [np.sqrt(area(line)) for line in level_lines(crop, (dark + bright) / 2)]
    return float(min(sides, key=lambda side: abs(side - rough), default=rough))


def _by_sheet(image: Array, corners: Array, square_mm: float) -> Marked:
    places, seen = _lattice(corners)
    if len(seen) < FEWEST:
        raise ValueError(
            f"shows {counted(len(seen), 'marker')} of a ChArUco sheet that belong together, {FEWEST} are "
            "needed; "
            "for a single marker there is --marker"
        )
    to_mm, _ = cv2.findHomography(corners[seen].mean(axis=1), places * square_mm, cv2.RANSAC, square_mm / 20)
    if to_mm is None:
        raise ValueError("its markers do not lie as on a ChArUco sheet")
    height, width = image.shape[:2]
    rim = np.array([(0, 0), (width, 0), (width, height), (0, height)], float)
    there = cv2.perspectiveTransform(rim[None], to_mm)[0]
    middles = cv2.perspectiveTransform(corners[seen].mean(axis=1)[None], to_mm)[0]
    off = float(np.sqrt(np.mean(np.sum((middles - places * square_mm) ** 2, axis=1))))
    lo, hi = there.min(axis=0), there.max(axis=0)
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    diagonal = np.hypot(width, height)
    if not np.linalg.norm(hi - lo) < 4 * diagonal * square_mm / sides.mean():
        raise ValueError("was taken at too flat a slant; take it from nearly straight above")
    mm_per_px = max(float((hi - lo).max()) / WIDEST, float((hi - lo).max()) / max(width, height))
    size = np.ceil((hi - lo) / mm_per_px).astype(int)
    place = np.array(
        [[1 / mm_per_px, 0, -lo[0] / mm_per_px], [0, 1 / mm_per_px, -lo[1] / mm_per_px], [0, 0, 1]]
    )
    straight = cv2.warpPerspective(
        image, place @ to_mm, size.tolist(), flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REPLICATE
    )
    moved = cv2.perspectiveTransform(corners.reshape(1, -1, 2), place @ to_mm).reshape(-1, 4, 2)
    taken = _around(moved, straight, together=True)
    outside = cv2.warpPerspective(np.ones((height, width), np.uint8), place @ to_mm, size.tolist()) == 0
    said = f"straightened out by {len(seen)} markers of a ChArUco sheet, which lie within {off:.2g} mm"
    return Marked(straight, mm_per_px, taken | outside, said)


def _lattice(corners: Array) -> tuple[Array, list[int]]:
    """Places (squares) of the markers that hang together, `(n, 2)`, and which they are.

    One after another: from each that has its place, by its own sides, to its diagonal neighbours. A marker's
    side is not known in squares, only that it is less than one and that neighbours lie at (+-1, +-1).
    """
    middles = corners.mean(axis=1)
    first = int(np.argmin(np.linalg.norm(middles - middles.mean(axis=0), axis=1)))
    placed, waiting = {first: np.zeros(2)}, [first]
    while waiting:
        at = waiting.pop(0)
        along = corners[at, 1] + corners[at, 2] - corners[at, 0] - corners[at, 3]
        down = corners[at, 2] + corners[at, 3] - corners[at, 0] - corners[at, 1]
        to = (middles - middles[at]) @ np.linalg.inv(np.stack([along, down]) / 2)
        for step in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            # In sides of the marker: one square is 1 to 2.2 of them.
            ahead = to @ np.array(step) / 2
            aside = np.abs(to @ np.array((step[1], -step[0]))) / 2
            near = np.flatnonzero((ahead > 1.0) & (ahead < 2.2) & (aside < 0.25 * ahead))
            if len(near):
                other = int(near[np.argmin(ahead[near])])
                if other not in placed:
                    placed[other] = placed[at] + step
                    waiting.append(other)
    seen = sorted(placed)
    return np.array([placed[i] for i in seen]), seen


def _around(corners: Array, image: Array, together: bool = False) -> Array:
    """Pixels of the markers, and half a marker around them; of a sheet all that lies between them too."""
    taken = np.zeros(image.shape[:2], np.uint8)
    groups = [corners.reshape(-1, 2)] if together else list(corners)
    for group in groups:
        hull = cv2.convexHull(np.round(group).astype(np.int32))
        cv2.fillConvexPoly(taken, hull, 1)
    side = float(np.linalg.norm(corners[0, 0] - corners[0, 1]))
    width = max(3, round(0.5 * side)) | 1
    return np.asarray(cv2.dilate(taken, np.ones((width, width), np.uint8)) > 0)
