"""Finding the lowest acquisition value inside the bounds (section 5 of the paper: Adam with saturation).

One start misses the minimum often, so a screened batch of starts runs at once.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple, Protocol

import numpy as np
from annotated_types import Interval

from deformpush.gp import bfgs
from deformpush.gp.profiles import Array
from deformpush.mechanics.rounding import lowest, lowest_first
from deformpush.optimizer.objective import Objective


class Minimum(NamedTuple):
    """What the search found."""

    u: Array
    """`(2,)`, model coordinates."""
    value: float
    evaluations: int
    """Points at which the acquisition was evaluated."""
    on_bound: bool


class Minimiser(Protocol):
    """Searches a box."""

    def __call__(self, objective: Objective, box: Array, seeds: Array, rng: np.random.Generator) -> Minimum:
        """Minimise over box `[[lo, hi], [lo, hi]]`; `seeds` `(k, 2)` are points worth a try."""


@dataclass(frozen=True)
class Adam:
    """Projected Adam (Kingma & Ba 2015) from the best of many screened points, all starts in one batch.

    Every iterate is saturated at the bounds. The step, in box widths, falls with a half cosine. At the end
    a projected BFGS takes the best point to the bottom of its valley.
    """

    screened: Annotated[int, Interval(ge=1, le=100_000)] = 512
    """Uniformly random points evaluated first."""
    starts: Annotated[int, Interval(ge=1, le=1000)] = 8
    """Best screened points that Adam starts from."""
    steps: Annotated[int, Interval(ge=0, le=10_000)] = 20
    rate: Annotated[float, Interval(gt=0, le=1)] = 0.05
    """First step, as a fraction of the box."""
    polish: bool = True
    """Whether BFGS follows."""
    incumbents: bool = True
    """Whether the latest and the most effective pushes are screened too."""

    def __call__(self, objective: Objective, box: Array, seeds: Array, rng: np.random.Generator) -> Minimum:
        """Minimise over box `[[lo, hi], [lo, hi]]`; `seeds` `(k, 2)` are points worth a try."""
        lo, hi = box.T
        seeds = seeds if self.incumbents else seeds[:0]
        points, values = screen(objective, box, seeds, self.screened, rng)
        chosen = lowest_first(values)[: self.starts]
        evaluations = len(points) + self.steps * len(chosen)
        u, value = self.descend(objective, box, points[chosen], values[chosen])
        if self.polish:
            u, value, more = polished(objective, box, u, value)
            evaluations += more
        return Minimum(u, value, evaluations, bool(np.any((u <= lo) | (u >= hi))))

    def descend(self, objective: Objective, box: Array, U: Array, values: Array) -> tuple[Array, float]:
        """Run Adam from all U `(n, 2)` at once and return the best point visited and its value."""
        lo, hi = box.T
        width = hi - lo
        best, least = U.copy(), values.copy()
        m, v = np.zeros_like(U), np.zeros_like(U)
        for step in range(1, self.steps + 1):
            values, gradient = objective.gradient(U)
            better = values < least
            best[better], least[better] = U[better], values[better]
            gradient = gradient * width
            m = 0.9 * m + 0.1 * gradient
            v = 0.999 * v + 0.001 * gradient**2
            rate = self.rate * 0.5 * (1.0 + np.cos(np.pi * (step - 1) / self.steps))
            move = (m / (1.0 - 0.9**step)) / (np.sqrt(v / (1.0 - 0.999**step)) + 1e-12)
            U = np.clip(U - rate * width * move, lo, hi)
        first = lowest(least)
        return best[first], float(least[first])


@dataclass(frozen=True)
class TorchAdam(Adam):
    """The same search with `torch.optim.Adam` making the steps: the paper's own tool, to compare with."""

    def descend(self, objective: Objective, box: Array, U: Array, values: Array) -> tuple[Array, float]:
        """Run torch's Adam from all U `(n, 2)` at once and return the best point visited and its value."""
        import torch

        lo, hi = box.T
        width = hi - lo
        best, least = U.copy(), values.copy()
        unit = torch.tensor((U - lo) / width, dtype=torch.float64)
        optimiser = torch.optim.Adam([unit], lr=self.rate)
        decay = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, max(self.steps, 1))
        for _ in range(self.steps):
            U = lo + unit.numpy() * width
            values, gradient = objective.gradient(U)
            better = values < least
            best[better], least[better] = U[better], values[better]
            unit.grad = torch.from_numpy(gradient * width)
            optimiser.step()
            decay.step()
            unit.clamp_(0.0, 1.0)
        first = lowest(least)
        return best[first], float(least[first])


@dataclass(frozen=True)
class BFGS:
    """Projected BFGS with exact gradients from the best of many screened points, one after the other."""

    screened: Annotated[int, Interval(ge=1, le=100_000)] = 512
    """Uniformly random points evaluated first."""
    starts: Annotated[int, Interval(ge=1, le=1000)] = 4
    """Best screened points that BFGS starts from."""

    def __call__(self, objective: Objective, box: Array, seeds: Array, rng: np.random.Generator) -> Minimum:
        """Minimise over box `[[lo, hi], [lo, hi]]`; `seeds` `(k, 2)` are points worth a try."""
        lo, hi = box.T
        points, values = screen(objective, box, seeds, self.screened, rng)
        evaluations = len(points)
        ends, found = [], []
        for i in lowest_first(values)[: self.starts]:
            end, value, more = polished(objective, box, points[i], float(values[i]))
            evaluations += more
            ends.append(end)
            found.append(value)
        first = lowest(np.array(found))
        u = ends[first]
        return Minimum(u, found[first], evaluations, bool(np.any((u <= lo) | (u >= hi))))


def screen(
    objective: Objective, box: Array, seeds: Array, n: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Evaluate the seeds, saturated at the bounds, and n uniform points: points `(k + n, 2)` and values."""
    lo, hi = box.T
    points = np.concatenate([np.clip(seeds, lo, hi), rng.uniform(lo, hi, (n, 2))])
    return points, objective.value(points)


def polished(objective: Objective, box: Array, u: Array, value: float) -> tuple[Array, float, int]:
    """Improve one point by projected BFGS in units of the box; keep the better of the two."""
    lo, hi = box.T
    width = hi - lo
    unit = max(abs(value), 1e-300)

    def scaled(x: Array) -> tuple[float, Array]:
        values, gradients = objective.gradient((lo + x * width)[None])
        return float(values[0]) / unit, gradients[0] * width / unit

    x, least, evaluations = bfgs.minimise(
        scaled, (u - lo) / width, np.zeros(2), np.ones(2), 30, tolerance=1e-13
    )
    better = least * unit < value
    return (np.clip(lo + x * width, lo, hi), least * unit, evaluations) if better else (u, value, evaluations)
