"""One Gaussian process in use: scaled data, hyper-parameters kept warm, posterior."""

from dataclasses import dataclass

import numpy as np

from deformpush.gp.fit import Fit, Fitted
from deformpush.gp.kernel import Kernel
from deformpush.gp.means import Mean
from deformpush.gp.profiles import Array
from deformpush.gp.regression import Posterior

MAX_FIT = 200
"""Newest samples that hyper-parameters are learnt from."""
MAX_KNOWN = 300
"""Newest samples that predictions are made from.

What a decision takes grows with its square. Across so many pushes k_t (Matern 5/2) is 1e-12 at a length scale
of 20 pushes, the median of its prior, and 3 % at one of 100.
"""


@dataclass(eq=False)
class Regressor:
    """A Gaussian process over (kappa, d, t) whose hyper-parameters start from those of the push before."""

    kernel: Kernel
    mean: Mean
    fit: Fit
    max_fit: int = MAX_FIT
    max_known: int = MAX_KNOWN
    theta: Array | None = None
    fitted: int = -1
    """Number of samples that theta was fitted to."""

    def condition(self, X: Array, y: Array, scale: float, now: float) -> tuple[Posterior, dict[str, float]]:
        """Fit the hyper-parameters, once for the same number of samples, and condition on the data.

        Args:
            X: samples `(S, 3)` in model coordinates, oldest first, S >= 1.
            y: what is modelled `(S,)`.
            scale: y is divided by it; 0: by the root mean square of what the kernel remembers.
            now: time of the next push.
        """
        S = len(y)
        known = self.kernel.remembers(X[:, 2], now)
        known[-1] = True
        known[: -self.max_known] = False
        X, y = X[known], y[known]
        scale = scale or scale_of(y)
        start = self.kernel.theta() if self.theta is None else self.theta
        newest = slice(-self.max_fit, None)
        again = self.fitted == S
        fitted = (
            Fitted(start) if again else self.fit(self.kernel, self.mean, X[newest], y[newest] / scale, start)
        )
        self.theta, self.fitted = fitted.theta, S
        posterior = Posterior.of(self.kernel, fitted.theta, self.mean, X, y, scale)
        info = dict(zip(self.kernel.names, np.exp(fitted.theta).tolist(), strict=True))
        info |= {
            "mu_0": posterior.level * scale,
            "scale": scale,
            "jitter": posterior.jitter,
            "fit_evaluations": float(fitted.evaluations),
            "fit_kept": float(fitted.kept),
            "samples": float(len(y)),
        }
        return posterior, info

    def state(self) -> tuple[Array, int]:
        """Hyper-parameters, nan before the first fit, and how many samples they were fitted to."""
        nothing = np.full(len(self.kernel.theta()), np.nan)
        return nothing if self.theta is None else self.theta.copy(), self.fitted

    def restore(self, theta: Array, fitted: int) -> None:
        """Take up what `state` returned."""
        self.theta = None if np.isnan(theta).any() else np.array(theta, float)
        self.fitted = int(fitted)


def scale_of(xi: Array) -> float:
    """Root mean square of xi `(S,)`, 1 where all are zero."""
    largest = float(np.abs(xi).max())
    # Dividing first keeps squares of very large or small numbers representable.
    return largest * float(np.sqrt(np.mean(np.square(xi / largest)))) if largest > 0 else 1.0
