"""From how the object may move to how the error may change: eqs. (1)-(4) over Monte Carlo draws, in torch."""

from collections.abc import Iterable
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from deformpush.state import State
from deformpush.task import SHAPE

if TYPE_CHECKING:
    from torch import Tensor

Array = np.ndarray


class Change(NamedTuple):
    """Mean and standard deviation of xi `(n,)`, and their derivatives `(n, 4)` where they were asked for."""

    mu: Array
    sigma: Array
    mu_by_mean: Array = np.empty(0)
    mu_by_std: Array = np.empty(0)
    sigma_by_mean: Array = np.empty(0)
    sigma_by_std: Array = np.empty(0)


class ErrorOfMotion:
    """xi = e_T(state moved by y) - e_T(state), y = mean + std z, the same normal draws z for every push.

    An outcome y is the displacement of the centroid in the object's frame (2, m), the turn (rad) and the
    change of the shape error (3).
    """

    def __init__(self, state: State, samples: int, ahead: Array | None = None) -> None:
        """For an object as `state` has it.

        Args:
            state: the object before the push.
            samples: number of draws; a scrambled Sobol sequence.
            ahead: mean outcomes `(K, 4)` of pushes that may follow, for looking two pushes ahead.
        """
        import torch

        self._pose, self._e_T = pose(state).tolist(), state.total_error
        self.z = normal_draws(samples)
        self.ahead = None if ahead is None else torch.from_numpy(ahead)
        origin = torch.zeros(1, 1, 4, dtype=torch.float64)
        self.stay = float(self._cost(origin)[0, 0])

    def change(self, mean: Array, std: Array) -> Change:
        """Mean and spread of xi for pushes with these outcomes `(n, 4)`."""
        import torch

        with torch.no_grad():
            y = torch.from_numpy(mean) + torch.from_numpy(std) * self.z[:, None]
            mu, sigma, _ = moments(self._cost(y) - self.stay)
        return Change(mu.numpy(), sigma.numpy())

    def gradient(self, mean: Array, std: Array) -> Change:
        """The same with derivatives."""
        import torch

        z = self.z[:, None]
        y = (torch.from_numpy(mean) + torch.from_numpy(std) * z).requires_grad_()
        xi = self._cost(y) - self.stay
        # Every draw of xi depends on its own draw of y alone: one pass back serves both moments.
        (slope,) = torch.autograd.grad(xi.sum(), y)
        mu, sigma, off = moments(xi.detach())
        lean = (off / sigma)[..., None] * slope
        by = (slope, slope * z, lean, lean * z)
        return Change(mu.numpy(), sigma.numpy(), *(g.mean(dim=0).numpy() for g in by))

    def _cost(self, y: "Tensor") -> "Tensor":
        """e_T `(N, n)` after outcomes `(N, n, 4)`; two pushes ahead: the mean of it and of the best after."""
        after = moved(self._pose, y)
        e_T: Tensor = self._e_T(*after)
        if self.ahead is None:
            return e_T
        then = moved([p[..., None] for p in after], self.ahead)
        best: Tensor = self._e_T(*then).amin(dim=-1)
        return 0.5 * (e_T + best.minimum(e_T))


def pose(state: State) -> Array:
    """Centroid x, y (m), angle (rad) and shape error (3) of the object `(4,)`: what an outcome changes."""
    return np.array([*state.seen.c, state.seen.theta, state.errors[SHAPE.symbol]])


def moments(xi: "Tensor") -> "tuple[Tensor, Tensor, Tensor]":
    """Mean and standard deviation `(n,)` over draws `(N, n)`, and the deviations of the draws."""
    mu = xi.mean(dim=0)
    off = xi - mu
    # Without the last term a push with certain effect would have no slope.
    return mu, ((off * off).mean(dim=0) + 1e-16).sqrt(), off


def moved(start: "Iterable[float | Tensor]", y: "Tensor") -> "tuple[Tensor, Tensor, Tensor, Tensor]":
    """x, y, theta and shape error after outcomes y `(..., 4)` from a start of the same four."""
    import torch

    x0, y0, theta, shape = (torch.as_tensor(p, dtype=torch.float64) for p in start)
    cos, sin = theta.cos(), theta.sin()
    x = x0 + cos * y[..., 0] - sin * y[..., 1]
    return x, y0 + sin * y[..., 0] + cos * y[..., 1], theta + y[..., 2], (shape + y[..., 3]).clamp(min=0.0)


@lru_cache(maxsize=8)
def normal_draws(samples: int) -> "Tensor":
    """Quasi-random standard normal draws `(samples, 4)`, the same at every call."""
    import torch

    uniform = torch.quasirandom.SobolEngine(4, scramble=True, seed=0).draw(  # type: ignore[no-untyped-call]
        samples, dtype=torch.float64
    )
    z = torch.special.ndtri(uniform.clamp(1e-9, 1 - 1e-9))
    # Exact first two moments: certain pushes keep their mean, linear errors their spread.
    return (z - z.mean(dim=0)) / z.std(dim=0, unbiased=False)
