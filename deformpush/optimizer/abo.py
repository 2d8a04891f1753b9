"""Adaptive Bayesian Optimization: the paper's optimizer (Algorithms 1, 2; Nyikosa et al. 2018)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import numpy as np
from annotated_types import Interval

from deformpush.cell.world import Capability
from deformpush.model.base import ModelComponents, Posterior
from deformpush.model.coordinates import from_model, grid, to_model
from deformpush.optimizer.acquisition import Context
from deformpush.optimizer.base import AskTellOptimizer, Components
from deformpush.optimizer.constraint import Feasible
from deformpush.optimizer.objective import Objective, OverSurface
from deformpush.state import Proposal, State

SEEDS = 8
"""So many of the latest pushes, and of the most effective ones, the minimiser may start from."""


@dataclass(frozen=True, eq=False)
class _Known:
    """What is known before a push."""

    posterior: Posterior
    feasible: Feasible
    objective: Objective


@dataclass(eq=False)
class ABO(AskTellOptimizer):
    """S0 pushes of an initial design, then the minimum of the acquisition over a model of xi(kappa, d, t).

    Time is the number of pushes told; it is pinned, never optimised. The static optimizer of textbooks is
    this one with `kernel.time: none`.
    """

    uses: ClassVar[frozenset[str]] = frozenset(
        {"bounds", "kernel", "mean", "fit", "model", "acquisition", "minimiser", "design"}
    )
    parts: Components
    S0: Annotated[int, Interval(ge=0, le=10_000)] = 10
    """Initial samples."""

    def __post_init__(self) -> None:
        """Draw the design; settle what depends on the contour.

        Raises:
            ValueError: the parts do not go together, or the model needs more samples than S0.
        """
        super().__init__(self.parts, self.S0)
        parts = self.parts
        kernel = parts.kernel.resolved(parts.closed)
        made_of = ModelComponents(kernel, parts.mean, parts.fit, parts.bounds.outer, parts.closed)
        self._learner = parts.model.learner(made_of)
        self._constraint = parts.acquisition.constraint(made_of)
        if self._learner.least > self.S0:
            raise ValueError(f"S0: {self.S0} is too few, this model and mean need {self._learner.least}")
        self._widest = to_model(made_of.outer.T, made_of.outer).T
        self._known: _Known | None = None

    @property
    def needs(self) -> frozenset[Capability]:
        """What the acquisition needs."""
        return self.parts.acquisition.needs

    def tell(self, u: Any, xi: Any, before: State | None = None, after: State | None = None) -> None:
        """Line 11, updateModel: learn that push u, asked for or not, changed e_T by xi.

        Raises:
            ValueError: u or xi is not finite, of the wrong shape, or outside the outer bounds (counted in
            `rejected`), or the model needs the states and they are missing.
        """
        outcome = self._learner.observe(u, before, after)
        measured = self._constraint.observe(before, after)
        super().tell(u, xi, before, after)
        self._learner.keep(outcome)
        self._constraint.keep(measured)
        self._known = None

    def predict(self, U: np.ndarray, state: State | None = None) -> tuple[np.ndarray, np.ndarray] | None:
        """Forecast of xi for pushes U `(n, 2)`, see `Optimizer.predict`.

        Raises:
            ValueError: the model must see the object, and `state` is missing.
        """
        if len(self.history) < self._learner.least:
            return None
        return self._know(state).posterior.predictive(to_model(np.asarray(U, float), self.history.outer))

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """`mean`, `std`, `acq` `(n, n)` over (d, kappa) in the outer bounds; empty before the first push.

        `acq` is nan where a push is not allowed.
        """
        if len(self.history) < max(1, self._learner.least):
            return {}
        known, ticks = self._know(None), np.linspace(0.0, 1.0, n)
        U = to_model(self._in_outer(grid(ticks, ticks)), self.history.outer)
        surface, objective = known.posterior.surface, known.objective
        mean, std = surface.predict(U)
        if isinstance(objective, OverSurface) and objective.surface is surface:
            value = objective.a(mean, std).a  # instead of predicting the same again
        else:
            value = objective.value(U)
        acq = np.where(known.feasible.allowed(U), value, np.nan)
        return {"mean": mean.reshape(n, n), "std": std.reshape(n, n), "acq": acq.reshape(n, n)}

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays and numbers only."""
        return super().state() | self._learner.state() | self._constraint.state()

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there.

        Raises:
            ValueError: it was saved under other outer bounds or another S0.
        """
        super().restore(state)
        self._learner.restore(state)
        self._constraint.restore(state)
        self._known = None

    def _initial(self, u: np.ndarray, state: State | None) -> Proposal:
        """Algorithm 1: the next point of the design, or the allowed push nearest to it.

        It learns from the first push on, during the design too: each fit of the hyper-parameters starts at
        the one before, so whoever looks at `maps` meanwhile must not be what makes it learn.
        """
        outer, proposal = self.history.outer, super()._initial(u, state)
        learns = len(self.history) >= self._learner.least
        feasible = self._know(state).feasible if learns else self._constraint.feasible(self._tried)
        choice = feasible.initial(to_model(u, outer), self._widest)
        if choice is None:
            return proposal
        u = np.clip(from_model(choice.u, outer), *outer.T)
        return replace(proposal, u=u, info=choice.notes, speed=choice.speed)

    def _choose(self, state: State | None) -> Proposal:
        """Algorithm 2: where to look, and the best push there."""
        now, outer = self._know(state), self.history.outer
        bounds = self._bounds_now(state)  # line 8: constAdaption
        box = to_model(bounds.T, outer).T
        best = self._tried[np.argsort(self.history.xi, kind="stable")[:SEEDS]]
        seeds = np.concatenate([self._tried[-SEEDS:], best])
        found = self.parts.minimiser(now.objective, box, seeds, self._rng(0))  # line 9: acquisition

        lowest = self._makeable(found.u)
        better, notes = now.posterior.instead(lowest, box)
        wanted = lowest if better is None else self._makeable(better)
        choice = now.feasible.choose(wanted, now.posterior, now.objective, box, self._widest)
        u = self._on_grid(np.clip(from_model(choice.u, outer), *(outer if choice.anywhere else bounds).T))
        made = to_model(u, outer)
        acq = float(now.objective.value(made[None])[0])
        mean, std = now.posterior.expected(made)
        facts = {"evaluations": float(found.evaluations), "on_bound": float(found.on_bound)}
        info = now.posterior.info | notes | choice.notes | facts
        phase = "exploit" if -mean > std else "explore"
        forecast = now.posterior.forecast(made)
        return Proposal(u, phase, bounds, acq, mean, std, info, forecast, choice.speed)

    def _makeable(self, u: np.ndarray) -> np.ndarray:
        """Push u `(2,)`, model coordinates, as it would be made: rounded."""
        outer = self.history.outer
        return to_model(self._on_grid(from_model(u, outer)), outer)

    def _know(self, state: State | None) -> _Known:
        """Posterior and acquisition as they are now, worked out once per push."""
        if self._known is None:
            tried, S = self._tried, len(self.history)
            posterior = self._learner.posterior(tried, self.history.xi, state)
            feasible = self._constraint.feasible(tried)
            context = Context(posterior.surface, tried, S, self._rng(1), feasible)
            self._known = _Known(posterior, feasible, self.parts.acquisition.objective(context))
        return self._known

    @property
    def _tried(self) -> np.ndarray:
        """Pushes told `(S, 2)`, model coordinates."""
        return to_model(self.history.U, self.history.outer)
