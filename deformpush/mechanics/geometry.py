"""Angles and rotations in the plane."""

import numpy as np

Array = np.ndarray


def rotation(angle: float) -> Array:
    """2D rotation matrix R(angle) `(2, 2)`."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def wrap(angle: Array | float) -> Array:
    """Angle(s) into [-pi, pi)."""
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi
