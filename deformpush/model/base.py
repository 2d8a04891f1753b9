"""What a model gives the optimizer: from what was pushed and seen to mu and sigma of xi over (kappa, d)."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from deformpush.gp.fit import Fit
from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Mean
from deformpush.model.rigid_push import RigidPush

Array = np.ndarray


class Ingredients(NamedTuple):
    """What a model is made of, besides its own settings."""

    kernel: Kernel
    """With `kappa` resolved."""
    mean: Mean | RigidPush
    fit: Fit
    outer: Array
    """`[[kappa_lo, kappa_hi], [d_lo, d_hi]]`, d in metres."""
    closed: bool
    """Whether kappa = 0 and kappa = 1 are the same point."""


class XiSurface(Protocol):
    """mu and sigma of xi over u = (kappa, d) in model coordinates at one time."""

    def predict(self, U: Array) -> tuple[Array, Array]:
        """Mu and sigma `(n,)` at U `(n, 2)`."""

    def gradient(self, U: Array) -> tuple[Array, Array, Array, Array]:
        """mu, sigma `(n,)` and their gradients `(n, 2)`."""

    def draw(self, time: float, features: int, rng: np.random.Generator) -> Any:
        """One function drawn from it, with `value` and `gradient`."""


class Belief(Protocol):
    """What is known before the next push."""

    @property
    def surface(self) -> XiSurface:
        """What the acquisition is taken over."""

    @property
    def info(self) -> dict[str, float]:
        """Named numbers for the record."""

    def expected(self, u: Array) -> tuple[float, float]:
        """Mean and standard deviation of xi of the very next push u `(2,)`."""

    def forecast(self, u: Array) -> tuple[Array, Array] | None:
        """Mean `(4,)` and covariance of centroid (m), angle (rad), e_gamma after u; None if unknown."""

    def instead(self, u: Array, box: Array) -> tuple[Array | None, dict[str, float]]:
        """A push in the box to make in place of u, or None to keep u; and notes for the record."""


class Learner(Protocol):
    """A model in use: it keeps what it learns besides u and xi."""

    least: int
    """Samples it needs before it can say anything."""

    def observe(self, u: Array, before: Any | None, after: Any | None) -> Any:
        """What is to be kept of a push; changes nothing.

        Raises:
            ValueError: it needs states and they are missing.
        """

    def keep(self, observed: Any) -> None:
        """Keep what `observe` returned."""

    def believe(self, U: Array, xi: Array, state: Any | None) -> Belief:
        """Learn from pushes U `(S, 2)` in model coordinates, oldest first, that changed e_T by xi `(S,)`."""

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""


class Model(Protocol):
    """Makes learners."""

    def learner(self, parts: Ingredients) -> Learner:
        """A learner that knows nothing yet.

        Raises:
            ValueError: the ingredients do not go together; the message starts with the wrong one's name.
        """
