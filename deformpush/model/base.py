"""What a model gives the optimizer: from what was pushed and seen to mu and sigma of xi over (kappa, d)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from deformpush.gp.fit import Fit
from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Mean
from deformpush.gp.sample_path import SamplePath
from deformpush.model.rigid_push import RigidPush
from deformpush.state import Forecast, State

Array = np.ndarray


@dataclass(frozen=True)
class ModelComponents:
    """What a model is made of, besides its own settings."""

    kernel: Kernel
    """With `kappa` resolved."""
    mean: Mean | RigidPush
    fit: Fit
    outer: Array
    """`[[kappa_lo, kappa_hi], [d_lo, d_hi]]`, d in metres."""
    closed: bool
    """Whether kappa = 0 and kappa = 1 are the same point."""


class Surface(Protocol):
    """Mean and standard deviation of something over u = (kappa, d) in model coordinates, at one time."""

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Mu and sigma `(n,)` at U `(n, 2)`."""

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """mu, sigma `(n,)` and their gradients `(n, 2)`."""

    def draw(self, features: int, rng: np.random.Generator) -> SamplePath:
        """One function drawn from it."""


class Posterior(Protocol):
    """What a model says of the next push."""

    @property
    def surface(self) -> Surface:
        """Of xi: what the acquisition is taken over."""

    @property
    def info(self) -> dict[str, float]:
        """Named numbers for the record."""

    def expected(self, u: Array) -> tuple[float, float]:
        """Mean and standard deviation of xi of the very next push u `(2,)`."""

    def predictive(self, U: Array) -> tuple[Array, Array]:
        """The same of what pushes U `(n, 2)` would be measured to do, noise included; each `(n,)`."""

    def forecast(self, u: Array) -> Forecast | None:
        """Where push u `(2,)` should bring the object; None if unknown."""

    def instead(self, u: Array, box: Array) -> tuple[Array | None, dict[str, float]]:
        """A push in the box to make in place of u, or None to keep u; and notes for the record."""


class Learner(Protocol):
    """A model in use: it keeps what it learns besides u and xi."""

    least: int
    """Samples it needs before it can say anything."""

    def observe(self, u: Array, before: State | None, after: State | None) -> Any:
        """What `keep` shall be given of a push; changes nothing.

        Raises:
            ValueError: it needs states and they are missing.
        """

    def keep(self, observed: Any) -> None:
        """Keep what `observe` returned."""

    def posterior(self, U: Array, xi: Array, state: State | None) -> Posterior:
        """Learn from pushes U `(S, 2)` in model coordinates, oldest first, that changed e_T by xi `(S,)`."""

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""


class Model(Protocol):
    """Makes learners."""

    def learner(self, parts: ModelComponents) -> Learner:
        """A learner that knows nothing yet.

        Raises:
            ValueError: the components do not go together; the message starts with the wrong one's name.
        """
