"""Pushes u = (kappa, d) as the models see them: d scaled to the outer bounds, kappa as it is."""

import numpy as np

Array = np.ndarray


def to_model(U: Array, outer: Array) -> Array:
    """Pushes `(n, 2)` or `(2,)` from d in metres; `outer` is `[[kappa_lo, kappa_hi], [d_lo, d_hi]]`."""
    lo, hi = outer[1]
    return np.asarray((U - np.array([0.0, lo])) / np.array([1.0, hi - lo]))


def from_model(U: Array, outer: Array) -> Array:
    """Pushes `(n, 2)` or `(2,)` back to d in metres."""
    lo, hi = outer[1]
    return np.asarray(U * np.array([1.0, hi - lo]) + np.array([0.0, lo]))


def share_of_longest(U: Array, d: Array | tuple[float, float]) -> Array:
    """Distance over d_max `(n,)` of pushes U `(n, 2)` in model coordinates; `d` is d_min, d_max (m)."""
    lo, hi = d
    return np.asarray((lo + U[:, 1] * (hi - lo)) / hi)


def grid(kappa: Array, d: Array) -> Array:
    """All pushes `(n_kappa n_d, 2)` of these kappa and d, in any coordinates; kappa runs faster."""
    return np.column_stack([x.ravel() for x in np.meshgrid(kappa, d)])


def grid_over(box: Array, n_kappa: int, n_d: int) -> Array:
    """Pushes `(n_kappa n_d, 2)` evenly over a box `[[lo, hi], [lo, hi]]`, its sides included."""
    (kappa_lo, kappa_hi), (d_lo, d_hi) = box
    return grid(np.linspace(kappa_lo, kappa_hi, n_kappa), np.linspace(d_lo, d_hi, n_d))
