"""Adaptive Bayesian Optimization: the paper's optimizer (Algorithms 1 and 2; Nyikosa, Osborne & Roberts 2018)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge

from deformpush.gp.regression import Posterior
from deformpush.optimizer.acquisition import Context, Objective
from deformpush.optimizer.history import History
from deformpush.optimizer.protocol import Parts, Proposal


@dataclass(frozen=True, eq=False)
class _Model:
    """The model after S pushes and the acquisition over it."""

    posterior: Posterior
    objective: Objective
    info: dict[str, float]


@dataclass
class ABO:
    """S0 pushes of an initial design, then the minimum of the acquisition over a model of xi(kappa, d, t).

    Time is the number of pushes told; it is pinned, never optimised. `ask` draws only from a generator derived
    from the seed and that number, so it can be repeated.
    """

    parts: Parts
    S0: Annotated[int, Ge(1)] = 10
    """Initial samples."""

    def __post_init__(self) -> None:
        """Draw the design and the seed of all later draws."""
        parts = self.parts
        self._kernel = parts.kernel.resolved(parts.closed)
        self._history = History(parts.bounds.outer)
        lo, hi = parts.bounds.outer.T
        self._design = lo + parts.design.points(self.S0, parts.rng) * (hi - lo)
        self._seed = int(parts.rng.integers(2**63))
        self._theta: np.ndarray | None = None
        self._fitted = -1
        self._model: _Model | None = None
        self._proposal: Proposal | None = None

    @property
    def rejected(self) -> int:
        """Tells refused so far."""
        return self._history.rejected

    def ask(self, state: Any | None = None) -> Proposal:
        """Choose the next push: the next design point, then the minimum of the acquisition inside the bounds."""
        if self._proposal is None:
            self._proposal = self._initial() if len(self._history) < self.S0 else self._acquire()
        return self._proposal

    def tell(self, u: np.ndarray, xi: float, state: Any | None = None) -> None:
        """Learn that push u, asked for or not, changed e_T by xi.

        Raises:
            ValueError: u or xi is not finite, of the wrong shape, or outside the outer bounds; it is counted in `rejected`.
        """
        self._history.add(u, xi)
        self._proposal = self._model = None

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """`mean`, `std`, `acq` `(n, n)` over (d, kappa) inside the outer bounds; empty before the first sample."""
        if not len(self._history):
            return {}
        model = self._conditioned()
        axes = np.linspace(*self._to_model(self.parts.bounds.outer.T), n)
        kappa, d = np.meshgrid(axes[:, 0], axes[:, 1])
        grid = np.stack([kappa.ravel(), d.ravel()], axis=1)
        mean, std = model.posterior.at(len(self._history)).predict(grid)
        return {
            "mean": mean.reshape(n, n),
            "std": std.reshape(n, n),
            "acq": model.objective.value(grid).reshape(n, n),
        }

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays and numbers only."""
        theta = np.full(5, np.nan) if self._theta is None else self._theta
        return self._history.state() | {
            "design": self._design.copy(),
            "seed": self._seed,
            "theta": theta.copy(),
            "fitted": self._fitted,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there.

        Raises:
            ValueError: it was saved under other outer bounds or another S0.
        """
        design = np.asarray(state["design"], float)
        if design.shape != (self.S0, 2):
            raise ValueError(f"restore: saved with S0={len(design)}, now S0={self.S0}")
        self._history.restore(state)
        self._design, self._seed = design, int(state["seed"])
        theta = np.array(state["theta"], float)
        self._theta, self._fitted = (None if np.isnan(theta).any() else theta), int(state["fitted"])
        self._proposal = self._model = None

    def _initial(self) -> Proposal:
        return Proposal(self._design[len(self._history)].copy(), "initial", self.parts.bounds.outer)

    def _acquire(self) -> Proposal:
        history, parts = self._history, self.parts
        model = self._conditioned()
        bounds = parts.bounds.now(history.U, history.xi)
        tried = self._to_model(history.U)
        best = tried[np.argsort(history.xi, kind="stable")[:8]]
        seeds = np.concatenate([tried[-8:], best])
        found = parts.minimiser(model.objective, self._to_model(bounds.T).T, seeds, self._rng("minimiser"))
        u = np.clip(self._from_model(found.u), *bounds.T)
        mean, std = (float(x[0]) for x in model.posterior.at(len(history)).predict(found.u[None]))
        info = model.info | {"evaluations": float(found.evaluations), "on_bound": float(found.on_bound)}
        phase = "exploit" if -mean > std else "explore"
        return Proposal(u, phase, bounds, found.value, mean, std, info)

    def _conditioned(self) -> _Model:
        """The model of now, fitted once per push."""
        if self._model is None:
            history, parts = self._history, self.parts
            S = len(history)
            tried = self._to_model(history.U)
            X = np.column_stack([tried, np.arange(S, dtype=float)])
            again = self._fitted == S
            posterior, info = parts.model.condition(
                self._kernel, parts.mean, parts.fit, X, history.xi, float(S), self._theta, refit=not again
            )
            self._theta, self._fitted = posterior.theta, S
            context = Context(posterior.at(float(S)), tried, S, self._rng("acquisition"))
            self._model = _Model(posterior, parts.acquisition.objective(context), info)
        return self._model

    def _rng(self, purpose: str) -> np.random.Generator:
        return np.random.default_rng([self._seed, len(self._history), purpose == "acquisition"])

    def _to_model(self, U: np.ndarray) -> np.ndarray:
        """(kappa, d in metres) `(n, 2)` to model coordinates: kappa as it is, d scaled to the outer bounds."""
        lo, hi = self.parts.bounds.outer[1]
        return (np.asarray(U) - (0.0, lo)) / (1.0, hi - lo)

    def _from_model(self, U: np.ndarray) -> np.ndarray:
        lo, hi = self.parts.bounds.outer[1]
        return np.asarray(U) * (1.0, hi - lo) + (0.0, lo)
