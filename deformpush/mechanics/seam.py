"""Where a contour begins: the point that lies in a given direction, found so that it does not jump.

Seen from the centroid of a star-shaped contour each direction shows one point. On an L or a ring sector a
direction meets the contour several times or never, and which point is nearest to it changes by the length of
an arm when the contour moves by a millimetre. There the contour's first harmonic is asked: of evenly spaced
points as complex numbers z_k, c_1 = mean(z_k exp(-2 pi i k / M)) draws a circle, run through at an even pace,
on which point k lies in direction arg c_1 + 2 pi k / M. That depends on every point a little and on none
much, turns with the contour and needs no centroid. In between, one answer passes over into the other.
"""

import numpy as np

from deformpush.mechanics.geometry import gyration, wrap
from deformpush.mechanics.outline_change import nearest
from deformpush.mechanics.rounding import lowest

Array = np.ndarray

FOLDED = 0.5
"""Contours that run back by this much, seen from the centroid, count as not star-shaped at all (rad)."""
ROOM = 0.1
"""Nor are those that pass the centroid nearer than this (radii of gyration): directions mean little there."""


def point_towards(contour: Array, c: Array, theta: float, angle: float = 0.0) -> int:
    """Index of the point of a contour that lies in a direction; of a star-shaped one, the nearest to it.

    Args:
        contour: `(M, 2)`, counter-clockwise, evenly spaced.
        c: its centroid `(2,)`.
        theta: its orientation (rad).
        angle: the direction, measured from theta (rad).
    """
    m = len(contour)
    polar = np.arctan2(*(contour - c).T[::-1]) - theta
    seen = lowest(np.abs(wrap(polar - angle)))
    steps = wrap(np.roll(polar, -1) - polar)
    away = _away_from_star_shaped(contour, c, steps)
    if away == 0:
        return seen
    first = np.mean(((contour - c) @ (1, 1j)) * np.exp(-2j * np.pi * np.arange(m) / m))
    even = (theta + angle - np.angle(first)) / (2 * np.pi) * m
    if away < 1:
        in_order = _in_order(polar[0] + np.append(0.0, np.cumsum(steps[:-1])), angle)
        even = in_order + away * float((even - in_order + m / 2) % m - m / 2)
    return round(even) % m


def _away_from_star_shaped(contour: Array, c: Array, steps: Array) -> float:
    """How far a contour is from star-shaped about c, in [0, 1]; `steps`: its changes of direction (rad)."""
    if abs(np.sum(steps)) < np.pi:  # c lies outside
        return 1.0
    back = float(np.sum(np.maximum(-steps, 0.0))) / FOLDED
    room = float(np.linalg.norm(nearest(c[None], contour)[0] - c)) / (ROOM * gyration(contour - c))
    return float(np.clip(max(back, 1 - room), 0.0, 1.0))


def _in_order(polar: Array, angle: float) -> float:
    """Fractional index at which directions `(M,)`, unwrapped, pass an angle (rad).

    Where they run back and forth, only those before and behind the fold count.
    """
    m = len(polar)
    index = np.arange(-m, 2 * m)
    around = np.concatenate([polar - 2 * np.pi, polar, polar + 2 * np.pi])
    rising = (around == np.maximum.accumulate(around)) & (around == np.minimum.accumulate(around[::-1])[::-1])
    target = polar[0] + (angle - polar[0]) % (2 * np.pi)
    return float(np.interp(target, around[rising], index[rising]))
