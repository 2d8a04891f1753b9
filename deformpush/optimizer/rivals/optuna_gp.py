"""Optuna's GP sampler (Akiba et al. 2019) as a rival."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from annotated_types import Interval

from deformpush.extras import library
from deformpush.optimizer.base import AskTellOptimizer, Components
from deformpush.state import Proposal, State


@dataclass(eq=False)
class OptunaGP(AskTellOptimizer):
    """GPSampler: Matern 5/2 ARD over (kappa, d) and log EI. It knows no time: a pinned input is dropped."""

    uses: ClassVar[frozenset[str]] = frozenset({"bounds", "design"})
    parts: Components
    S0: Annotated[int, Interval(ge=1, le=10_000)] = 10

    def __post_init__(self) -> None:
        """Draw the design, and fail at once if the library is missing."""
        library("optuna")
        super().__init__(self.parts, self.S0)

    def _choose(self, state: State | None) -> Proposal:
        import warnings

        import optuna

        history, bounds = self.history, self._bounds_now(state)
        outer = self._spread(optuna, history.outer)
        quiet = optuna.logging.get_verbosity()
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
                sampler = optuna.samplers.GPSampler(
                    seed=int(self._rng().integers(2**31)), n_startup_trials=self.S0
                )
            study = optuna.create_study(sampler=sampler)
            study.add_trials(
                [
                    optuna.create_trial(params={"kappa": k, "d": d}, distributions=outer, value=float(xi))
                    for (k, d), xi in zip(history.U.tolist(), history.xi, strict=True)
                ]
            )
            params = study.ask(outer).params
        finally:
            optuna.logging.set_verbosity(quiet)
        return Proposal(np.clip([params["kappa"], params["d"]], *bounds.T), "explore", bounds)

    @staticmethod
    def _spread(optuna: Any, limits: np.ndarray) -> dict[str, Any]:
        """Optuna's search space for `[[kappa_lo, kappa_hi], [d_lo, d_hi]]`."""
        kappa, d = limits.tolist()
        return {
            "kappa": optuna.distributions.FloatDistribution(*kappa),
            "d": optuna.distributions.FloatDistribution(*d),
        }
