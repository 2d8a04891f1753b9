"""What the best push would have gained, and how well a model foresaw what pushes do: the numbers of one push.

The push made and those tried instead begin in the same state; xi is the change of e_T, so less is better.
"""

from dataclasses import dataclass

import numpy as np

from deformpush.record.forecasts import INSIDE
from deformpush.record.regret_table import Numbers

Array = np.ndarray


@dataclass(frozen=True)
class Trials:
    """Pushes tried from one state, the last of them the push made, and what a model said before."""

    U: Array
    """(kappa, d) `(n+1, 2)`, d in metres."""
    xi: Array
    """Change of e_T `(n+1,)`; nan where a push failed."""
    mean: Array
    """Forecast of xi `(n+1,)`; nan without a model."""
    std: Array
    """Its standard deviation `(n+1,)`, noise included."""

    def numbers(self) -> Numbers:
        """Regret and calibration of the push made."""
        made, others = self.xi[-1], self.xi[:-1]
        worked = np.isfinite(others)
        best = int(np.nanargmin(self.xi))
        return {
            "xi_best": float(self.xi[best]),
            "kappa_best": float(self.U[best, 0]),
            "d_best": float(self.U[best, 1]),
            "regret": float(made - self.xi[best]),
            "rank": 1 + int(np.sum(others[worked] < made)),
            "trials": len(others),
            "failed": int(np.sum(~worked)),
            "xi_tried": float(others[worked].mean()) if worked.any() else np.nan,
            "xi_mean": float(self.mean[-1]),
            "xi_std": float(self.std[-1]),
            "best_mean": float(self.mean[best]),
            "best_std": float(self.std[best]),
        } | self._of_the_model()

    def _of_the_model(self) -> Numbers:
        """How the forecasts of the trials, without the push made, compare with what came; nan without any."""
        xi, mean, std = self.xi[:-1], self.mean[:-1], self.std[:-1]
        known = np.isfinite(xi) & np.isfinite(mean)
        names = ("inference_regret", "inside_95", "z_mean", "z_rms", "rmse", "kendall_tau")
        if not known.any():
            return dict.fromkeys(names, np.nan)
        off = xi[known] - mean[known]
        z = off / std[known]
        believed = np.where(np.isfinite(self.xi), self.mean, np.inf)
        values = (
            self.xi[np.argmin(believed)] - np.nanmin(self.xi),
            np.mean(np.abs(z) <= INSIDE),
            z.mean(),
            np.sqrt(np.mean(z**2)),
            np.sqrt(np.mean(off**2)),
            kendall_tau(mean[known], xi[known]),
        )
        return {name: float(value) for name, value in zip(names, values, strict=True)}


def kendall_tau(a: Array, b: Array) -> float:
    """Kendall's rank correlation tau-b of a and b `(n,)`; nan where one of them is constant."""
    one, other = (np.sign(x[:, None] - x) for x in (a, b))
    norm = np.sqrt(np.sum(one**2) * np.sum(other**2))
    return float(np.sum(one * other) / norm) if norm else np.nan
