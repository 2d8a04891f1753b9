"""The turn and shift that best lay one contour on another, over the whole circle, and a contour's symmetry.

A contour `(M, 2)` is a closed polygon in metres. Where the points of two evenly spaced contours correspond,
up to a cyclic shift, the best turn has a closed form for every shift; one FFT gives them all. But points
slide along an outline that is seen with noise, so the best few turns are refined: each point is paired with
the nearest place on the other contour and its distance from the side there is made small (iterative closest
points, with lines: Chen and Medioni, Image and Vision Computing 10, 1992).
"""

from dataclasses import dataclass

import numpy as np

from deformpush.mechanics.geometry import gyration, resample, rotation, wrap
from deformpush.mechanics.outline_change import nearest_sides

Array = np.ndarray

POINTS = 128
"""Contours are compared at so many points each."""
SYMMETRIC = 0.02
"""A contour this near to one that is symmetric counts as symmetric (rms distance over rms radius)."""
HIGHEST = 8
"""Orders of symmetry above this are round: a regular nonagon is a disc to within `SYMMETRIC`."""
ROUND = 0
"""Order of symmetry of a disc."""
_HARMONICS = 20  # what is finer than a twentieth of the outline is noise of pixels
_SMOOTH = 32  # harmonics that are kept in a fit (standard deviation); noise of pixels tilts single sides
_STARTS, _PROMISING = 6, 0.8  # so many turns are refined, if their match is this share of the best one's
_GLANCE, _ROUNDS = 3, 30  # steps that show which start is best; at most so many for that one
_STILL = 1e-6  # rad; a smaller step ends the refinement


@dataclass(frozen=True)
class Registration:
    """A rigid motion that lays a contour on a later one: turn about its centroid, then shift."""

    angle: float | None
    """Turn (rad), in [-pi, pi) unless a turn to be near was given; None where the contour is round."""
    shift: Array
    """Motion of the mean of the contour's evenly spaced points `(2,)` (m)."""
    residual: float
    """Root mean square distance that remains between them (m)."""


@dataclass(frozen=True)
class Symmetry:
    """How many turns lay a contour on itself."""

    order: int
    """1: only the whole turn; 2: also the half; and so on; `ROUND`: every turn."""
    confidence: float
    """0 where the order is as good as tossed between two, towards 1 where no doubt remains."""

    def nearest(self, angle: float, near: float) -> float:
        """The angle (rad) nearest to another one among all that look alike."""
        if self.order == ROUND:
            return near
        step = 2 * np.pi / self.order
        return float(angle + step * np.round((near - angle) / step))


def register(
    was: Array, now: Array, near: float | None = None, guess: float | None = None, order: int | None = None
) -> Registration:
    """Find how a contour `(M, 2)` has moved from what is seen of it now `(N, 2)`.

    Args:
        was: the contour before (m).
        now: the contour after (m), turned by any angle.
        near: where turns look alike by symmetry, the one nearest to this is told (rad); by default the least.
        guess: of the promising turns the one nearest to this (rad) is tried first; if it makes the contours
            alike, no other is.
        order: of the symmetry, where it is known.
    """
    a, b = (_smoothed(resample(contour, POINTS)) for contour in (was, now))
    symmetric = symmetry(was) if order is None else Symmetry(order, 1.0)
    if symmetric.order == ROUND:
        _, shift, residual = _refined(a, b, 0.0, _GLANCE)
        return Registration(None, shift, residual)
    starts, fit = _turns(a, b), None
    if guess is not None:
        fit = _refined(a, b, starts[np.argmin(np.abs(wrap(starts - guess)))], _ROUNDS)
    if fit is None or fit[2] > SYMMETRIC * gyration(a - a.mean(axis=0)):
        fits = [_refined(a, b, turn, _GLANCE) for turn in starts]
        fit = _refined(a, b, min(fits, key=lambda fit: fit[2])[0], _ROUNDS)
    turn, shift, residual = fit
    if near is None:
        return Registration(float(wrap(symmetric.nearest(turn, 0.0))), shift, residual)
    return Registration(symmetric.nearest(turn, near), shift, residual)


def symmetry(contour: Array) -> Symmetry:
    """The order of symmetry of a contour `(M, 2)`.

    With evenly spaced points as complex numbers, a shape that a turn by 2 pi / k lays on itself has only the
    harmonics 1, 1 + k, 1 - k, 1 + 2 k, ... What is in the others is how far the contour is from one that has
    the symmetry.
    """
    z = np.fft.fft(resample(contour, POINTS) @ (1, 1j))
    n = np.fft.fftfreq(POINTS, 1 / POINTS).astype(int)
    power = np.where((n != 0) & (np.abs(n) <= _HARMONICS), np.abs(z) ** 2, 0.0)
    others = [power[(n - 1) % k != 0].sum() for k in range(2, HIGHEST + 1)]
    away = np.sqrt([0.0, *others, power[n != 1].sum()] / power.sum())  # orders 1 to HIGHEST, and round
    holds = away < SYMMETRIC
    found = int(np.flatnonzero(holds)[-1])
    doubt = np.where(holds, away / SYMMETRIC, SYMMETRIC / np.maximum(away, 1e-12))
    # Orders that divide the one found hold with it; whether they do decides nothing.
    deciding = [found, *np.flatnonzero(~holds)]
    return Symmetry(ROUND if found == HIGHEST else found + 1, float(1 - doubt[deciding].max()))


def _smoothed(contour: Array) -> Array:
    """An evenly spaced contour `(n, 2)` without its finest ripples."""
    n = len(contour)
    z = np.fft.fft(contour @ (1, 1j)) * np.exp(-0.5 * (np.fft.fftfreq(n, 1 / n) / _SMOOTH) ** 2)
    smooth = np.fft.ifft(z)
    return np.stack([smooth.real, smooth.imag], axis=1)


def _turns(a: Array, b: Array) -> Array:
    """The best turns (rad) of one contour `(n, 2)` onto another, whichever points correspond."""
    za, zb = ((c - c.mean(axis=0)) @ (1, 1j) for c in (a, b))
    matched = np.fft.ifft(np.conj(np.fft.fft(za)) * np.fft.fft(zb))
    quality = np.abs(matched)
    peak = (quality >= np.roll(quality, 1)) & (quality > np.roll(quality, -1))
    peak &= quality >= _PROMISING * quality.max()
    best = np.argsort(-np.where(peak, quality, 0.0), kind="stable")[: min(_STARTS, np.count_nonzero(peak))]
    return np.asarray(np.angle(matched[best]))


def _refined(a: Array, b: Array, turn: float, rounds: int) -> tuple[float, Array, float]:
    """Turn (rad), shift of the mean `(2,)` and residual (m) from `a` to `b`, improved from a first turn.

    In each round `b`, laid on `a` as known so far, is turned about its mean and moved so that the distances
    of its points from the sides of `a` nearest to them become least (Gauss and Newton).
    """
    centre, middle = a.mean(axis=0), b.mean(axis=0)
    side = np.roll(a, -1, axis=0) - a
    normal = np.stack([side[:, 1], -side[:, 0]], axis=1) / np.linalg.norm(side, axis=1)[:, None]
    at = centre  # where the mean of b lies when laid on a
    for _ in range(rounds):
        arm = (b - middle) @ rotation(-turn).T
        place, which = nearest_sides(arm + at, a)
        n = normal[which]
        rows = np.column_stack([arm[:, 0] * n[:, 1] - arm[:, 1] * n[:, 0], n])
        step = np.linalg.lstsq(rows, np.sum((place - arm - at) * n, axis=1), rcond=1e-6)[0]
        turn, at = turn - float(step[0]), at + step[1:]
        if abs(step[0]) < _STILL:
            break
    laid = (b - middle) @ rotation(-turn).T + at
    place, _ = nearest_sides(laid, a)
    residual = float(np.sqrt(np.mean(np.sum((laid - place) ** 2, axis=1))))
    return turn, middle - centre + rotation(turn) @ (centre - at), residual
