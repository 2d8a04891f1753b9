"""Finding the lowest acquisition value inside the bounds (section 5 of the paper: Adam with saturation).

One start misses the minimum often, so a screened batch of starts runs at once.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple, Protocol

import numpy as np
from annotated_types import Ge, Gt

from deformpush.gp import bfgs
from deformpush.optimizer.acquisition import Objective


class Minimum(NamedTuple):
    """What the search found."""

    u: np.ndarray
    """`(2,)`, model coordinates."""
    value: float
    evaluations: int
    """Points at which the acquisition was evaluated."""
    on_bound: bool


class Minimiser(Protocol):
    """Searches a box."""

    def __call__(
        self, objective: Objective, box: np.ndarray, seeds: np.ndarray, rng: np.random.Generator
    ) -> Minimum:
        """Minimise over box `[[lo, hi], [lo, hi]]`; `seeds` `(k, 2)` are points worth a try."""


@dataclass(frozen=True)
class Adam:
    """Projected Adam (Kingma & Ba 2015) from the best of many screened points, all starts in one batch.

    Every iterate is saturated at the bounds. The step, in box widths, falls with a half cosine. At the end a projected
    BFGS takes the best point to the bottom of its valley.
    """

    screened: Annotated[int, Ge(1)] = 512
    """Uniformly random points evaluated first."""
    starts: Annotated[int, Ge(1)] = 8
    """Best screened points that Adam starts from."""
    steps: Annotated[int, Ge(0)] = 40
    rate: Annotated[float, Gt(0)] = 0.05
    """First step, as a fraction of the box."""
    polish: bool = True

    def __call__(
        self, objective: Objective, box: np.ndarray, seeds: np.ndarray, rng: np.random.Generator
    ) -> Minimum:
        """Minimise over box `[[lo, hi], [lo, hi]]`; `seeds` `(k, 2)` are points worth a try."""
        lo, hi = box.T
        points, values = screen(objective, box, seeds, self.screened, rng)
        chosen = np.argsort(values, kind="stable")[: self.starts]
        evaluations = len(points) + self.steps * len(chosen)
        u, value = self.descend(objective, box, points[chosen], values[chosen])
        if self.polish:
            u, value, more = polished(objective, box, u, value)
            evaluations += more
        return Minimum(u, value, evaluations, bool(np.any((u <= lo) | (u >= hi))))

    def descend(
        self, objective: Objective, box: np.ndarray, U: np.ndarray, values: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """Run Adam from all U `(n, 2)` at once and return the best point visited and its value."""
        lo, hi = box.T
        width = hi - lo
        best, lowest = U.copy(), values.copy()
        m, v = np.zeros_like(U), np.zeros_like(U)
        for step in range(1, self.steps + 1):
            values, gradient = objective.gradient(U)
            better = values < lowest
            best[better], lowest[better] = U[better], values[better]
            gradient = gradient * width
            m = 0.9 * m + 0.1 * gradient
            v = 0.999 * v + 0.001 * gradient**2
            rate = self.rate * 0.5 * (1.0 + np.cos(np.pi * (step - 1) / self.steps))
            move = (m / (1.0 - 0.9**step)) / (np.sqrt(v / (1.0 - 0.999**step)) + 1e-12)
            U = np.clip(U - rate * width * move, lo, hi)
        first = int(np.argmin(lowest))
        return best[first], float(lowest[first])


def screen(
    objective: Objective, box: np.ndarray, seeds: np.ndarray, n: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Evaluate the seeds, saturated at the bounds, and n uniform points: points `(k + n, 2)` and values."""
    lo, hi = box.T
    points = np.concatenate([np.clip(seeds, lo, hi), rng.uniform(lo, hi, (n, 2))])
    return points, objective.value(points)


def polished(
    objective: Objective, box: np.ndarray, u: np.ndarray, value: float
) -> tuple[np.ndarray, float, int]:
    """Improve one point by projected BFGS in units of the box; keep the better of the two."""
    lo, hi = box.T
    width = hi - lo
    unit = max(abs(value), 1e-300)

    def scaled(x: np.ndarray) -> tuple[float, np.ndarray]:
        values, gradients = objective.gradient((lo + x * width)[None])
        return float(values[0]) / unit, gradients[0] * width / unit

    x, lowest, evaluations = bfgs.minimise(
        scaled, (u - lo) / width, np.zeros(2), np.ones(2), 30, tolerance=1e-8
    )
    better = lowest * unit < value
    return (
        (np.clip(lo + x * width, lo, hi), lowest * unit, evaluations) if better else (u, value, evaluations)
    )
