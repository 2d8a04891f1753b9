"""The model of the paper: one Gaussian process on xi, the change of the total error."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge

from deformpush.gp.fit import Fit, Fitted
from deformpush.gp.kernels import NAMES, Kernel
from deformpush.gp.means import Mean
from deformpush.gp.regression import Posterior


@dataclass(frozen=True)
class ErrorModel:
    """xi ~ GP(mu_0, k) over (kappa, d, t). xi is divided by its root mean square, never centred.

    Centring would turn "forgotten" into "average", although an untried push is expected to change nothing.
    """

    max_fit: Annotated[int, Ge(1)] = 200
    """Hyper-parameters are learnt from the newest samples only, at most this many; predictions use all."""

    def condition(
        self,
        kernel: Kernel,
        mean: Mean,
        fit: Fit,
        X: np.ndarray,
        xi: np.ndarray,
        now: float,
        last: np.ndarray | None,
        refit: bool = True,
    ) -> tuple[Posterior, dict[str, float]]:
        """Fit the hyper-parameters and condition on the data.

        Args:
            kernel: with `kappa` resolved.
            mean: prior mean.
            fit: hyper-parameter choice.
            X: samples `(S, 3)` in model coordinates, oldest first, S >= 1.
            xi: change of the total error `(S,)`.
            now: time of the next push.
            last: theta of the decision before, or None.
            refit: False takes `last` as it is (it was fitted to these very data).

        Returns:
            The posterior, and named numbers for the record.
        """
        known = kernel.remembers(X[:, 2], now)
        known[-1] = True
        X, xi = X[known], xi[known]
        scale = scale_of(xi)
        start = kernel.theta() if last is None else last
        newest = slice(-self.max_fit, None)
        fitted = fit(kernel, mean, X[newest], xi[newest] / scale, start) if refit else Fitted(start)
        posterior = Posterior.of(kernel, fitted.theta, mean, X, xi, scale)
        info = dict(zip(NAMES, np.exp(fitted.theta).tolist(), strict=True))
        info |= {
            "mu_0": posterior.level * scale,
            "scale": scale,
            "jitter": posterior.jitter,
            "fit_evaluations": float(fitted.evaluations),
            "fit_kept": float(fitted.kept),
            "samples": float(len(xi)),
        }
        return posterior, info


def scale_of(xi: np.ndarray) -> float:
    """Root mean square of xi `(S,)`, 1 where all are zero."""
    largest = float(np.abs(xi).max())
    # Dividing first keeps squares of very large or small numbers representable.
    return largest * float(np.sqrt(np.mean(np.square(xi / largest)))) if largest > 0 else 1.0
