"""Adaptive Bayesian Optimization: the paper's optimizer (Algorithms 1, 2; Nyikosa et al. 2018)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge

from deformpush.gp.regression import Posterior
from deformpush.optimizer.acquisition import Context, Objective
from deformpush.optimizer.asker import Asker
from deformpush.optimizer.protocol import Parts, Proposal


@dataclass(frozen=True, eq=False)
class _Model:
    """The model after S pushes and the acquisition over it."""

    posterior: Posterior
    objective: Objective
    info: dict[str, float]


@dataclass(eq=False)
class ABO(Asker):
    """S0 pushes of an initial design, then the minimum of the acquisition over a model of xi(kappa, d, t).

    Time is the number of pushes told; it is pinned, never optimised. The static optimizer of textbooks is
    this one with `kernel.time: none`.
    """

    parts: Parts
    S0: Annotated[int, Ge(1)] = 10
    """Initial samples."""

    def __post_init__(self) -> None:
        """Draw the design; settle what depends on the contour."""
        super().__init__(self.parts, self.S0)
        self._kernel = self.parts.kernel.resolved(self.parts.closed)
        self._theta: np.ndarray | None = None
        self._fitted = -1
        self._model: _Model | None = None

    def tell(self, u: Any, xi: Any, state: Any | None = None) -> None:
        """Learn that push u, asked for or not, changed e_T by xi.

        Raises:
            ValueError: u or xi is not finite, of the wrong shape, or outside the outer bounds; counted in
            `rejected`.
        """
        super().tell(u, xi, state)
        self._model = None

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """`mean`, `std`, `acq` `(n, n)` over (d, kappa) in the outer bounds; empty before the first push."""
        if not len(self.history):
            return {}
        model = self._conditioned()
        ticks = np.linspace(0.0, 1.0, n)
        kappa, d = np.meshgrid(ticks, ticks)
        grid = self._to_model(self._in_outer(np.stack([kappa.ravel(), d.ravel()], axis=1)))
        mean, std = model.posterior.at(len(self.history)).predict(grid)
        acq = model.objective.value(grid)
        return {"mean": mean.reshape(n, n), "std": std.reshape(n, n), "acq": acq.reshape(n, n)}

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays and numbers only."""
        theta = np.full(5, np.nan) if self._theta is None else self._theta
        return super().state() | {"theta": theta.copy(), "fitted": self._fitted}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there.

        Raises:
            ValueError: it was saved under other outer bounds or another S0.
        """
        super().restore(state)
        theta = np.array(state["theta"], float)
        self._theta, self._fitted = (None if np.isnan(theta).any() else theta), int(state["fitted"])
        self._model = None

    def _choose(self, state: Any | None) -> Proposal:
        history = self.history
        model = self._conditioned()
        bounds = self._bounds_now(state)
        tried = self._to_model(history.U)
        best = tried[np.argsort(history.xi, kind="stable")[:8]]
        seeds = np.concatenate([tried[-8:], best])
        found = self.parts.minimiser(model.objective, self._to_model(bounds.T).T, seeds, self._rng(0))
        u = np.clip(self._from_model(found.u), *bounds.T)
        mean, std = (float(x[0]) for x in model.posterior.at(len(history)).predict(found.u[None]))
        info = model.info | {"evaluations": float(found.evaluations), "on_bound": float(found.on_bound)}
        phase = "exploit" if -mean > std else "explore"
        return Proposal(u, phase, bounds, found.value, mean, std, info)

    def _conditioned(self) -> _Model:
        """The model of now, fitted once per push."""
        if self._model is None:
            history, parts = self.history, self.parts
            S = len(history)
            tried = self._to_model(history.U)
            X = np.column_stack([tried, np.arange(S, dtype=float)])
            again = self._fitted == S
            posterior, info = parts.model.condition(
                self._kernel, parts.mean, parts.fit, X, history.xi, float(S), self._theta, refit=not again
            )
            self._theta, self._fitted = posterior.theta, S
            context = Context(posterior.at(float(S)), tried, S, self._rng(1))
            self._model = _Model(posterior, parts.acquisition.objective(context), info)
        return self._model

    def _to_model(self, U: np.ndarray) -> np.ndarray:
        """(kappa, d in metres) `(n, 2)` to model coordinates: d scaled to the outer bounds."""
        lo, hi = self.history.outer[1]
        return np.asarray((U - np.array([0.0, lo])) / np.array([1.0, hi - lo]))

    def _from_model(self, U: np.ndarray) -> np.ndarray:
        lo, hi = self.history.outer[1]
        return np.asarray(U * np.array([1.0, hi - lo]) + np.array([0.0, lo]))
