"""How much an object is deformed, from two contours of it: what a camera can know of strain.

One contour is of the object at rest, the other of the same object later, moved and deformed. No material
point can be recognised on a smooth outline, so nothing here is a strain proper; each measure is a number
without unit that is zero for a rigid motion. How well they rank pushes by the strain inside is in
docs/strain.md.
"""

from dataclasses import dataclass

import numpy as np

from deformpush.mechanics.geometry import matched_turn, resample, rotation, signed_area

Array = np.ndarray

POINTS = 128
"""Contours are compared at so many points each."""
SMOOTH = 1 / 60
"""Curvature is taken over this share of the outline (standard deviation): some 10 mm, the width of a tool."""
ROUNDS = 3
"""Of refining the rigid fit; a fourth moves nothing that a camera sees."""


@dataclass(frozen=True)
class ContourChange:
    """Difference between two contours of one object, whatever its motion (-). Lengths are over sqrt(area)."""

    area: float
    """Area over the area before, minus 1."""
    length: float
    """Length of the outline over its length before, minus 1."""
    curvature: float
    """Root mean square of the change of curvature."""
    residual: float
    """Root mean square distance between the contours after the best rigid fit."""
    dent: float
    """Largest such distance."""


def contour_change(before: Array, after: Array) -> ContourChange:
    """Compare contours `(M, 2)` and `(N, 2)` (m) of one object, turned by at most 60 degrees in between."""
    was, now = resample(before, POINTS), resample(after, POINTS)
    area, length = signed_area(was), _length(was)
    scale = np.sqrt(area)
    apart, shift = rigid_fit(was, now)
    bent = np.roll(curvature(now), -shift) - curvature(was)
    return ContourChange(
        signed_area(now) / area - 1,
        _length(now) / length - 1,
        float(np.sqrt(np.mean(bent**2)) * scale),
        float(np.sqrt(np.mean(apart**2)) / scale),
        float(apart.max() / scale),
    )


def rigid_fit(was: Array, now: Array) -> tuple[Array, int]:
    """Lay one contour on another by turning and moving it, as well as a rigid motion can.

    First by Procrustes analysis of evenly spaced points at the best cyclic shift; but points slide along an
    outline that has grown. So each point is then paired with the nearest place on the other outline, and the
    fit repeated (iterative closest points, Besl and McKay 1992).

    Args:
        was: contour `(n, 2)`, evenly spaced.
        now: contour `(n, 2)` of the same object later.

    Returns:
        Distance of each point of `now` from the outline of `was` `(n,)` (m), and the point of `now` that
        lies where the first point of `was` does.
    """
    turn = matched_turn(was - was.mean(axis=0), now - now.mean(axis=0))
    laid = (now - now.mean(axis=0)) @ rotation(-turn).T + was.mean(axis=0)
    for _ in range(ROUNDS):
        laid = _procrustes(laid, nearest(laid, was))
    apart = np.linalg.norm(laid - nearest(laid, was), axis=1)
    return apart, int(np.argmin(np.linalg.norm(laid - was[0], axis=1)))


def nearest(points: Array, contour: Array) -> Array:
    """Nearest places `(P, 2)` on a closed polygon `(V, 2)` to points `(P, 2)`."""
    return nearest_sides(points, contour)[0]


def nearest_sides(points: Array, contour: Array) -> tuple[Array, Array]:
    """Nearest places `(P, 2)` on a closed polygon `(V, 2)`, and the sides `(P,)` they lie on.

    Side i runs from corner i to the next.
    """
    sx, sy = (np.roll(contour, -1, axis=0) - contour).T
    gx, gy = (points[:, None, k] - contour[:, k] for k in (0, 1))
    along = np.clip((gx * sx + gy * sy) / (sx**2 + sy**2), 0.0, 1.0)
    gx -= along * sx
    gy -= along * sy
    best = np.argmin(gx**2 + gy**2, axis=1)
    rows = np.arange(len(points))
    return points - np.stack([gx[rows, best], gy[rows, best]], axis=1), best


def curvature(contour: Array) -> Array:
    """Curvature (1/m) `(n,)` of an evenly spaced closed contour `(n, 2)`, smoothed along it."""
    n = len(contour)
    wave = np.fft.fftfreq(n, 1 / n)
    z = np.fft.fft(contour[:, 0] + 1j * contour[:, 1]) * np.exp(-0.5 * (2 * np.pi * SMOOTH * wave) ** 2)
    first, second = np.fft.ifft(2j * np.pi * wave * z), np.fft.ifft(-((2 * np.pi * wave) ** 2) * z)
    return np.asarray(np.imag(np.conj(first) * second) / np.abs(first) ** 3)


def _procrustes(points: Array, onto: Array) -> Array:
    """Points `(n, 2)` turned and moved to lie nearest to their partners (Kabsch 1976, in the plane)."""
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    turn = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    return np.asarray(a @ rotation(float(turn)).T + onto.mean(axis=0))


def _length(contour: Array) -> float:
    return float(np.linalg.norm(np.roll(contour, -1, axis=0) - contour, axis=1).sum())
