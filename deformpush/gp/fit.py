"""Choosing the hyper-parameters: as configured, or by maximum a posteriori."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple, Protocol

import numpy as np
from annotated_types import Interval

from deformpush.gp import bfgs
from deformpush.gp.correlation import LogNormal
from deformpush.gp.kernel import Kernel
from deformpush.gp.means import Mean
from deformpush.gp.profiles import Array
from deformpush.gp.regression import log_likelihood
from deformpush.mechanics.rounding import LOGARITHMS, rounded

SAME_TOP = 1e-6
"""Densities whose logarithms differ by less than this share are of one top: both searches found it."""


class Fitted(NamedTuple):
    """Hyper-parameters and how they were found."""

    theta: Array
    evaluations: int = 0
    kept: bool = False
    """The search failed and the last good values were kept."""


class Fit(Protocol):
    """Chooses theta for the data."""

    def __call__(self, kernel: Kernel, mean: Mean, X: Array, y: Array, last: Array) -> Fitted:
        """Return theta for scaled data y `(S,)` at X `(S, 3)`; `last` are the values used before."""


@dataclass(frozen=True)
class Fixed:
    """The values of the kernel's configuration, for ever."""

    def __call__(self, kernel: Kernel, mean: Mean, X: Array, y: Array, last: Array) -> Fitted:
        """Return the kernel's own values."""
        return Fitted(kernel.theta())


@dataclass(frozen=True)
class MAP:
    """argmax log p(Y | X, theta) + log p(theta), log-normal priors, by projected BFGS from the last values.

    With ten samples the likelihood alone is nearly flat and over-fits; the priors say what is plausible for
    pushes, and from about forty samples on they no longer matter. Further numbers that a kernel learns bring
    their own.
    """

    rho_kappa: LogNormal = (0.3, 2.7)
    rho_d: LogNormal = (0.3, 2.7)
    rho_t: LogNormal = (20.0, 3.5)
    sigma_f: LogNormal = (1.0, 2.7)
    noise: LogNormal = (0.1, 3.5)
    span: Annotated[float, Interval(ge=0.01, le=100)] = 3.0
    """The search stays within median / factor^span and median * factor^span."""
    iterations: Annotated[int, Interval(ge=1, le=10_000)] = 40
    """Line searches of the projected BFGS."""
    restart_until: Annotated[int, Interval(ge=0, le=100_000)] = 20
    """Up to this many samples the search also starts from the medians."""

    def __call__(self, kernel: Kernel, mean: Mean, X: Array, y: Array, last: Array) -> Fitted:
        """Maximise the density of the learnable entries of theta; the others keep the kernel's values."""
        common = (self.rho_kappa, self.rho_d, self.rho_t, self.sigma_f, self.noise)
        priors = np.log([*common, *kernel.further_priors])
        learn = kernel.learnable()
        median, sd = priors[learn, 0], priors[learn, 1]
        distances, theta = kernel.distances(X), kernel.theta()
        work = np.empty((len(theta) - 1, distances.shape[1]))

        def negative_log_density(z: Array) -> tuple[float, Array]:
            """Over z = (theta - median) / sd, in which the prior is a unit Gaussian."""
            full = theta.copy()
            full[learn] = median + z * sd
            value, gradient = log_likelihood(kernel, full, mean, distances, y, work)
            return 0.5 * float(z @ z) - value, z - gradient[learn] * sd

        limit = np.full(len(median), self.span)
        warm = (last[learn] - median) / sd
        # While samples are few the density changes much from push to push; later the last top is the place.
        starts = (warm, np.zeros_like(warm)) if len(y) <= self.restart_until else (warm,)
        best, evaluations = None, 0
        for start in starts:
            try:
                z, value, n = bfgs.minimise(negative_log_density, start, -limit, limit, self.iterations, 1e-8)
            except np.linalg.LinAlgError:
                continue
            evaluations += n
            # Where both lead to the same top, they differ there by what the search leaves: the first counts.
            if np.isfinite(value) and (best is None or value < best[1] - SAME_TOP * (1.0 + abs(value))):
                best = (z, value)
        if best is None:
            return Fitted(last, evaluations, kept=True)
        theta[learn] = rounded(median + best[0] * sd, LOGARITHMS)
        return Fitted(theta, evaluations)
