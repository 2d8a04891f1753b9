"""Projected BFGS for a handful of variables in a box: fits hyper-parameters and polishes acquisitions."""

from collections.abc import Callable

import numpy as np

Objective = Callable[[np.ndarray], tuple[float, np.ndarray]]


def minimise(
    fun: Objective,
    x: np.ndarray,
    lo: np.ndarray,
    hi: np.ndarray,
    iterations: int = 60,
    tolerance: float = 1e-12,
) -> tuple[np.ndarray, float, int]:
    """Minimise fun over the box `lo <= x <= hi` from x (Nocedal & Wright 2006, algorithm 6.1, projected).

    Variables on a bound that the gradient pushes outwards rest until it pulls them back. Stops when a
    full step promises a decrease below `tolerance` (1 + |value|), or no step along the direction helps.

    Args:
        fun: x `(n,)` -> value and gradient `(n,)`.
        x: start `(n,)`.
        lo: lower bounds `(n,)`.
        hi: upper bounds `(n,)`.
        iterations: at most this many line searches.
        tolerance: promised relative decrease at which to stop.

    Returns:
        Best x `(n,)`, its value, number of evaluations.
    """
    x = np.clip(x, lo, hi)
    value, gradient = fun(x)
    evaluations = 1
    H = np.eye(len(x)) / max(1.0, float(np.abs(gradient).max()))
    for step in range(iterations):
        free = ~(((x <= lo) & (gradient > 0)) | ((x >= hi) & (gradient < 0)))
        downhill = np.where(free, gradient, 0.0)
        direction = np.where(free, -(H @ downhill), 0.0)
        if direction @ gradient >= 0:
            direction, H = -downhill, np.eye(len(x))
        if -(direction @ gradient) <= tolerance * (1.0 + abs(value)):
            break
        length = 1.0
        for _ in range(25):
            trial = np.clip(x + length * direction, lo, hi)
            moved = trial - x
            trial_value, trial_gradient = fun(trial)
            evaluations += 1
            if trial_value <= value + 1e-4 * float(gradient @ moved):
                break
            length *= 0.4
        else:
            break
        # Only what moved teaches curvature: with the resting variables in, H would mix two subspaces.
        change = np.where(moved != 0, trial_gradient - gradient, 0.0)
        curvature = float(moved @ change)
        if curvature > 1e-12 * float(np.linalg.norm(moved) * np.linalg.norm(change)):
            if step == 0:
                H = np.eye(len(x)) * curvature / float(change @ change)
            rotate = np.eye(len(x)) - np.outer(moved, change) / curvature
            H = rotate @ H @ rotate.T + np.outer(moved, moved) / curvature
        x, value, gradient = trial, trial_value, trial_gradient
    return x, value, evaluations
