"""Geometry in the plane: angles, rotations, polygons and lines by arc length."""

import numpy as np

Array = np.ndarray


def rotation(angle: float) -> Array:
    """2D rotation matrix R(angle) `(2, 2)`."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def wrap(angle: Array | float, order: int = 1) -> Array:
    """Angle(s) (rad) into [-pi, pi), or into that share of it that the order of a symmetry leaves."""
    half = np.pi / order
    return (np.asarray(angle) + half) % (2 * half) - half


def principal_axis(centred: Array) -> tuple[float, float]:
    """Angle of the first principal direction of points `(M, 2)` (rad, modulo pi), and sigma_2 / sigma_1."""
    values, vectors = np.linalg.eigh(centred.T @ centred)
    ratio = np.sqrt(max(values[0], 0.0) / values[1]) if values[1] > 0 else 1.0
    return float(np.arctan2(vectors[1, 1], vectors[0, 1])), float(ratio)


def matched_turn(before: Array, after: Array) -> float:
    """Rotation (rad, within +-60 degrees) that best lays one centred contour on another, whatever the shift.

    With points as complex numbers a and b, C(s) = sum_i conj(a_i) b_(i+s); the rotation that best fits at
    shift s is arg C(s) and the quality of the fit is |C(s)|.
    """
    a, b = before[:, 0] + 1j * before[:, 1], after[:, 0] + 1j * after[:, 1]
    correlation = np.fft.ifft(np.conj(np.fft.fft(a)) * np.fft.fft(b))
    turn = np.angle(correlation)
    allowed = np.abs(turn) <= np.pi / 3
    return float(turn[np.argmax(np.where(allowed, np.abs(correlation), -1.0))])


def resample(polygon: Array, m: int) -> Array:
    """`m` points evenly spaced by arc length along a closed polygon `(V, 2)`, counter-clockwise."""
    if signed_area(polygon) < 0:
        polygon = polygon[::-1]
    closed = np.concatenate([polygon, polygon[:1]])
    length = arc_length(closed)
    return _at(np.arange(m) * length[-1] / m, length, closed)


def arc_length(line: Array) -> Array:
    """Distance `(V,)` of each point of a line `(V, 2)` from its first, along the line."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def gyration(centred: Array) -> float:
    """Radius of gyration of points `(M, 2)` about the origin."""
    return float(np.sqrt(np.mean(np.sum(centred**2, axis=1))))


def signed_area(polygon: Array) -> float:
    """Area of a polygon `(V, 2)`, positive when counter-clockwise."""
    x, y = polygon.T
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def _at(distance: Array, length: Array, line: Array) -> Array:
    """Points `(m, 2)` at distances `(m,)` along a line whose points lie at `length` `(V,)`."""
    return np.stack([np.interp(distance, length, line[:, i]) for i in (0, 1)], axis=1)
