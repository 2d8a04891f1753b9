"""Limits that pushes must keep to, as an optimizer sees them; none, unless the acquisition brings some."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from deformpush.gp.profiles import Array
from deformpush.model.base import Posterior
from deformpush.optimizer.objective import Objective
from deformpush.state import State


@dataclass(frozen=True, eq=False)
class Choice:
    """A push to make."""

    u: Array
    """`(2,)`, model coordinates."""
    speed: float | None = None
    """Of the tool (m/s); None: as the world is set."""
    notes: dict[str, float] = field(default_factory=dict)
    """For the record."""
    anywhere: bool = False
    """Whether it may lie outside the bounds of now; never outside the outer ones."""


class Feasible(Protocol):
    """Which pushes are allowed next. All are in model coordinates, boxes are `[[lo, hi], [lo, hi]]`."""

    def walled(self, objective: Objective) -> Objective:
        """The objective with minima where pushes are allowed."""

    def allowed(self, U: Array) -> np.ndarray:
        """Which of pushes U `(n, 2)` are allowed: bool `(n,)`."""

    def initial(self, u: Array, outer: Array) -> Choice | None:
        """The push to make in place of a point of the design `(2,)`; None: that point."""

    def choose(
        self, u: Array, posterior: Posterior, objective: Objective, box: Array, outer: Array
    ) -> Choice:
        """The push to make where u `(2,)` is wanted, if need be outside the box that was searched."""


class Constraint(Protocol):
    """Learns from pushes which are allowed."""

    def observe(self, before: State | None, after: State | None) -> Any:
        """What `keep` shall be given of a push; changes nothing.

        Raises:
            ValueError: the states lack what it needs.
        """

    def keep(self, observed: Any) -> None:
        """Keep what `observe` returned."""

    def feasible(self, U: Array) -> Feasible:
        """What is allowed after pushes U `(S, 2)` in model coordinates, oldest first."""

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""


class Unconstrained:
    """No limits: a constraint that learns nothing, and allows everything."""

    def observe(self, before: State | None, after: State | None) -> None:
        """Every push is as good as any."""

    def keep(self, observed: None) -> None:
        """There is nothing to learn."""

    def feasible(self, U: Array) -> "Unconstrained":
        """Everything, always."""
        return self

    def walled(self, objective: Objective) -> Objective:
        """The objective as it is."""
        return objective

    def allowed(self, U: Array) -> np.ndarray:
        """All of them `(n,)`."""
        return np.ones(len(U), bool)

    def initial(self, u: Array, outer: Array) -> None:
        """The point of the design as it is."""

    def choose(
        self, u: Array, posterior: Posterior, objective: Objective, box: Array, outer: Array
    ) -> Choice:
        """The push that is wanted."""
        return Choice(u)

    def state(self) -> dict[str, Any]:
        """Empty."""
        return {}

    def restore(self, state: Mapping[str, Any]) -> None:
        """There is nothing to take up."""
