"""Where the object points and where its contour begins: by its principal axis, or by its first contour."""

from typing import TYPE_CHECKING

import numpy as np

from deformpush.cell.observation import FirstLook, Observation
from deformpush.mechanics.geometry import matched_turn, principal_axis, rotation, wrap
from deformpush.mechanics.registration import HIGHEST, ROUND, register, symmetry
from deformpush.mechanics.rounding import RADIANS, lowest, rounded
from deformpush.mechanics.seam import point_towards

if TYPE_CHECKING:
    from deformpush.cell.mask import MaskGrid

Array = np.ndarray

UPRIGHT = np.pi / 2 - 1e-6
"""From this angle on an axis stands upright, and of its two ends the upper one counts (rad)."""
SAME_MASK = 0.05
"""Masks that differ by less than this share of their area are alike: a third of what usually ends a run."""


def at_first(contour: Array, c: Array) -> tuple[Array, float, float]:
    """The contour `(M, 2)`, begun where it lies in direction theta from c, theta (rad), sigma_2 / sigma_1.

    Theta is the end of the principal axis that points to the right.
    """
    axis, ratio = principal_axis(contour - c)
    right = float(wrap(2 * axis) / 2)
    theta = float(rounded(right + np.pi if right < -UPRIGHT else right, RADIANS))
    return np.roll(contour, -point_towards(contour, c, theta), axis=0), theta, ratio


def by_axis(contour: Array, c: Array, previous: Observation, most: float) -> tuple[Array, float, bool]:
    """The same by PCA, theta continuous in time, and whether PCA was too ill-posed to give it.

    Args:
        contour: `(M, 2)` (m).
        c: its centroid `(2,)`.
        previous: what was seen before, the object turned by at most 60 degrees since.
        most: share of the larger standard deviation that the smaller one may have.
    """
    centred = contour - c
    axis, ratio = principal_axis(centred)
    expected = previous.theta + matched_turn(previous.contour - previous.c, centred)
    theta = axis + np.pi * np.round((expected - axis) / np.pi)
    # An axis far from where the contour itself says it turned has swapped with the other one: hold.
    held = bool(ratio > most or abs(theta - expected) > np.pi / 4)
    theta = float(rounded(expected if held else theta, RADIANS))
    return np.roll(contour, -point_towards(contour, c, theta), axis=0), theta, held


def by_registration(contour: Array, c: Array, first: FirstLook, near: float) -> tuple[Array, float]:
    """The contour, begun at the place where the first one began, and theta, by laying the first one on it.

    Args:
        contour: `(M, 2)` (m).
        c: its centroid `(2,)`.
        first: what was seen first.
        near: of turns that look alike the one nearest to this is taken (rad).
    """
    angle = register(first.body, contour, near, guess=near, order=first.order).angle
    if angle is None:
        return np.roll(contour, -point_towards(contour, c, near), axis=0), near
    theta = float(rounded(angle, RADIANS))
    return np.roll(contour, -_shift(first.body @ rotation(theta).T, contour - c), axis=0), theta


def order_of_symmetry(body: Array, masks: "MaskGrid") -> int:
    """The order of symmetry of a centred contour `(M, 2)` (m), found on it and confirmed on its mask.

    An order that does not hold for the mask gives way to one that divides it.
    """
    found, mask = symmetry(body).order, masks.draw(body)
    orders = [ROUND, *range(HIGHEST, 1, -1)] if found == ROUND else range(found, 1, -1)
    for order in orders:
        turned = masks.draw(body @ rotation(2 * np.pi / (order or HIGHEST + 1)).T)
        if (order == ROUND or found % order == 0) and np.sum(mask ^ turned) <= SAME_MASK * np.sum(mask):
            return order
    return 1


def _shift(was: Array, now: Array) -> int:
    """Index of the point of an evenly spaced contour `(M, 2)` at which another such contour begins."""
    a, b = was @ (1, 1j), now @ (1, 1j)
    return lowest(-np.real(np.fft.ifft(np.conj(np.fft.fft(a)) * np.fft.fft(b))))
