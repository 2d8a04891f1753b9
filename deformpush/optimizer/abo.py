"""Adaptive Bayesian Optimization: the paper's optimizer (Algorithms 1, 2; Nyikosa et al. 2018)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge

from deformpush.model.base import Belief, Ingredients
from deformpush.optimizer.acquisition import Context, Guarding, Objective
from deformpush.optimizer.base import AskTellOptimizer, Components
from deformpush.optimizer.safe_set import Allowance
from deformpush.state import Forecast, Proposal


@dataclass(frozen=True, eq=False)
class _Outlook:
    """What is believed before the next push, and the acquisition over it."""

    belief: Belief
    objective: Objective
    allowance: Allowance | None


@dataclass(eq=False)
class ABO(AskTellOptimizer):
    """S0 pushes of an initial design, then the minimum of the acquisition over a model of xi(kappa, d, t).

    Time is the number of pushes told; it is pinned, never optimised. The static optimizer of textbooks is
    this one with `kernel.time: none`.
    """

    parts: Components
    S0: Annotated[int, Ge(0)] = 10
    """Initial samples."""

    def __post_init__(self) -> None:
        """Draw the design; settle what depends on the contour.

        Raises:
            ValueError: the parts do not go together, or the model needs more samples than S0.
        """
        super().__init__(self.parts, self.S0)
        parts = self.parts
        kernel = parts.kernel.resolved(parts.closed)
        made_of = Ingredients(kernel, parts.mean, parts.fit, parts.bounds.outer, parts.closed)
        self._learner = parts.model.learner(made_of)
        self._guard = parts.acquisition.guard(made_of) if isinstance(parts.acquisition, Guarding) else None
        if self._learner.least > self.S0:
            raise ValueError(f"S0: {self.S0} is too few, this model and mean need {self._learner.least}")
        self._now: _Outlook | None = None

    def ask(self, state: Any | None = None) -> Proposal:
        """Choose the next push; see `AskTellOptimizer.ask`.

        It learns from the first push on, during the design too: each fit of the hyper-parameters starts at
        the one before, so whoever looks at `maps` meanwhile must not be what makes it learn.
        """
        known = self._proposal is not None
        proposal = super().ask(state)
        if len(self.history) >= self._learner.least:
            self._look(state)
        if self._guard is not None and not known and proposal.phase == "initial":
            self._proposal = proposal = self._held_back(proposal)
        return proposal

    def tell(self, u: Any, xi: Any, before: Any | None = None, after: Any | None = None) -> None:
        """Learn that push u, asked for or not, changed e_T by xi and the state from `before` to `after`.

        Raises:
            ValueError: u or xi is not finite, of the wrong shape, or outside the outer bounds (counted in
            `rejected`), or the model needs the states and they are missing.
        """
        observed = self._learner.observe(u, before, after)
        peak = None if self._guard is None else self._guard.observe(before, after)
        super().tell(u, xi, before, after)
        self._learner.keep(observed)
        if self._guard is not None and peak is not None:
            self._guard.keep(peak)
        self._now = None

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """`mean`, `std`, `acq` `(n, n)` over (d, kappa) in the outer bounds; empty before the first push.

        `acq` is nan where a push is not allowed.
        """
        if len(self.history) < max(1, self._learner.least):
            return {}
        now = self._look(None)
        ticks = np.linspace(0.0, 1.0, n)
        kappa, d = np.meshgrid(ticks, ticks)
        grid = self._to_model(self._in_outer(np.stack([kappa.ravel(), d.ravel()], axis=1)))
        mean, std = now.belief.surface.predict(grid)
        acq = now.objective.value(grid)
        if now.allowance is not None:
            acq = np.where(now.allowance.excess(grid) <= 0.0, acq, np.nan)
        return {"mean": mean.reshape(n, n), "std": std.reshape(n, n), "acq": acq.reshape(n, n)}

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays and numbers only."""
        return super().state() | self._learner.state() | (self._guard.state() if self._guard else {})

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there.

        Raises:
            ValueError: it was saved under other outer bounds or another S0.
        """
        super().restore(state)
        self._learner.restore(state)
        if self._guard is not None:
            self._guard.restore(state)
        self._now = None

    def _choose(self, state: Any | None) -> Proposal:
        history = self.history
        now = self._look(state)
        bounds = self._bounds_now(state)
        tried = self._to_model(history.U)
        best = tried[np.argsort(history.xi, kind="stable")[:8]]
        seeds = np.concatenate([tried[-8:], best])
        box = self._to_model(bounds.T).T

        speed = float("nan")
        held: dict[str, float] = {}
        found = self.parts.minimiser(now.objective, box, seeds, self._rng(0))
        better, notes = now.belief.instead(found.u, box)
        wanted = found.u if better is None else better
        if now.allowance is not None:
            outer = self._to_model(history.outer.T).T
            wanted, held = now.allowance.nearest(wanted, now.objective.value, [box, outer])
            if now.belief.expected(wanted)[0] >= 0.0:
                wanted, held = self._elsewhere(now, wanted, held, outer)
            speed, safe = self._paced(now.allowance, wanted)
            notes = notes | held | safe
        if wanted is not found.u:
            found = found._replace(u=wanted, value=float(now.objective.value(wanted[None])[0]))
        u = np.clip(self._from_model(found.u), *(history.outer if held else bounds).T)
        mean, std = now.belief.expected(found.u)
        facts = {"evaluations": float(found.evaluations), "on_bound": float(found.on_bound)}
        info = now.belief.info | notes | facts
        phase = "exploit" if -mean > std else "explore"
        forecast = now.belief.forecast(found.u)
        ahead = None if forecast is None else Forecast(*forecast)
        return Proposal(u, phase, bounds, found.value, mean, std, info, ahead, speed)

    @staticmethod
    def _elsewhere(
        now: _Outlook, u: np.ndarray, held: dict[str, float], outer: np.ndarray
    ) -> tuple[np.ndarray, dict[str, float]]:
        """A short push that is expected to help, where no allowed one is; the given one if there is none.

        Without it the allowed set could end on one side of the object, and every push lead farther away. It
        is the most helpful of those that are expected to stay under the limit; if none of these helps, and
        none is allowed either, the most helpful of the gentlest that do: of those whose peaks differ by less
        than that of one push, repeated, would.
        """
        assert now.allowance is not None
        shortest, over = now.allowance.shortest(outer)
        mean, _ = now.belief.surface.predict(shortest)
        helps = mean < 0.0
        gentle = helps & (over <= 0.0)
        if gentle.any():
            return shortest[np.argmin(np.where(gentle, mean, np.inf))], {"begun_elsewhere": 1.0}
        if helps.any() and "no_safe_push" in held:
            gentlest = helps & (over <= over[helps].min() + now.allowance.noise)
            return shortest[np.argmin(np.where(gentlest, mean, np.inf))], held
        return u, held

    @staticmethod
    def _paced(allowance: Allowance, u: np.ndarray) -> tuple[float, dict[str, float]]:
        """The speed for push u (nan: not free), and the probability that it is gentle enough."""
        v = allowance.fastest(u)
        return v if allowance.speeds[1] else float("nan"), {"p_safe": allowance.probability(u, v)}

    def _look(self, state: Any | None) -> _Outlook:
        """What is believed now, worked out once per push."""
        if self._now is None:
            history = self.history
            S, tried = len(history), self._to_model(history.U)
            belief = self._learner.believe(tried, history.xi, state)
            allowance = self._guard.allowance(tried) if self._guard else None
            context = Context(belief.surface, tried, S, self._rng(1), allowance)
            self._now = _Outlook(belief, self.parts.acquisition.objective(context), allowance)
        return self._now

    def _held_back(self, proposal: Proposal) -> Proposal:
        """The point of the design, or the allowed push nearest to it."""
        assert self._guard is not None
        tried, outer = self._to_model(self.history.U), self._to_model(self.history.outer.T).T
        allowance = self._guard.allowance(tried)
        point = self._to_model(proposal.u[None])[0]
        u, notes = allowance.nearest(point, lambda U: np.sum((U - point) ** 2, axis=1), [outer])
        speed, safe = self._paced(allowance, u)
        u = np.clip(self._from_model(u), *self.history.outer.T)
        return replace(proposal, u=u, info=notes | safe, speed=speed)

    def _to_model(self, U: np.ndarray) -> np.ndarray:
        """(kappa, d in metres) `(n, 2)` to model coordinates: d scaled to the outer bounds."""
        lo, hi = self.history.outer[1]
        return np.asarray((U - np.array([0.0, lo])) / np.array([1.0, hi - lo]))

    def _from_model(self, U: np.ndarray) -> np.ndarray:
        lo, hi = self.history.outer[1]
        return np.asarray(U * np.array([1.0, hi - lo]) + np.array([0.0, lo]))
