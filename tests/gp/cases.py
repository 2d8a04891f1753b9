"""Kernels and samples shared by the tests of the Gaussian process."""

import numpy as np

from deformpush.gp import Matern32, Matern52, Matern52Sum, SquaredExponential

FAMILIES = (Matern52, Matern32, SquaredExponential, Matern52Sum)
TIMES = ("matern52", "matern32", "ou", "tv", "window", "none")
KERNELS = [
    family(time=time, kappa=kappa) for family in FAMILIES for time in TIMES for kappa in ("open", "periodic")
]
EVERY_FACTOR = KERNELS[::13] + KERNELS[:12] + KERNELS[1:48:13]
"""Every spatial kernel, every time kernel and both shapes of kappa, not all their combinations."""
THETA = np.log([0.35, 0.6, 12.0, 0.9, 0.1])


def samples(S, seed):
    """X `(S, 3)` at times 0..S-1 and a smooth, drifting, noisy xi `(S,)`."""
    rng = np.random.default_rng(seed)
    X = np.column_stack([rng.random((S, 2)), np.arange(S)])
    xi = np.sin(5 * X[:, 0] + 0.1 * X[:, 2]) - X[:, 1] + 0.05 * rng.normal(size=S)
    return X, xi
