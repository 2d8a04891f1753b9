"""BoTorch (Balandat et al. 2020) as a rival: its GP, its fit, its acquisition optimiser."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np
from annotated_types import Interval

from deformpush.extras import library
from deformpush.optimizer.base import AskTellOptimizer, Components
from deformpush.state import Proposal, State


@dataclass(eq=False)
class BoTorch(AskTellOptimizer):
    """SingleTaskGP, marginal likelihood by L-BFGS-B, UCB by `optimize_acqf` with the time pinned.

    `kernel: separable` is Matern 5/2 ARD over (kappa, d) times Matern 5/2 over t with a constant mean and
    standardised data, as a user of the library would build eq. (7); `default` leaves its own kernel and
    priors over the same three inputs.
    """

    uses: ClassVar[frozenset[str]] = frozenset({"bounds", "design"})
    parts: Components
    S0: Annotated[int, Interval(ge=1, le=10_000)] = 10
    kernel: Literal["separable", "default"] = "separable"
    w: Annotated[float, Interval(ge=0, le=1e6)] = 2.0
    restarts: Annotated[int, Interval(ge=1, le=1000)] = 8
    raw_samples: Annotated[int, Interval(ge=1, le=100_000)] = 64

    def __post_init__(self) -> None:
        """Draw the design, and fail at once if the library is missing."""
        library("botorch")
        super().__init__(self.parts, self.S0)

    def _choose(self, state: State | None) -> Proposal:
        import torch
        from botorch.acquisition.analytic import UpperConfidenceBound
        from botorch.fit import fit_gpytorch_mll
        from botorch.models import SingleTaskGP
        from botorch.models.transforms import Standardize
        from botorch.optim.optimize import optimize_acqf
        from gpytorch.kernels import MaternKernel, ScaleKernel
        from gpytorch.mlls import ExactMarginalLogLikelihood

        history, (lo, hi) = self.history, self.history.outer.T
        S = len(history)
        # Time runs over the same unit interval as the pushes, as the library's scaling advice has it.
        X = torch.tensor(np.column_stack([(history.U - lo) / (hi - lo), np.arange(S) / 30.0]))
        covariance = None
        if self.kernel == "separable":
            space = MaternKernel(nu=2.5, ard_num_dims=2, active_dims=(0, 1))
            covariance = ScaleKernel(space * MaternKernel(nu=2.5, active_dims=(2,)))
        seed = int(self._rng().integers(2**31))
        with torch.random.fork_rng(), np.errstate(all="ignore"):
            torch.manual_seed(seed)
            model = SingleTaskGP(
                X,
                torch.tensor(history.xi)[:, None],
                covar_module=covariance,
                outcome_transform=Standardize(1),
            )
            fit_gpytorch_mll(ExactMarginalLogLikelihood(model.likelihood, model))
            bounds = self._bounds_now(state)
            box = (bounds.T - lo) / (hi - lo)
            now = np.full((2, 1), S / 30.0)
            point, value = optimize_acqf(
                UpperConfidenceBound(model, beta=self.w**2, maximize=False),
                torch.tensor(np.hstack([box, now])),
                q=1,
                num_restarts=self.restarts,
                raw_samples=self.raw_samples,
                fixed_features={2: S / 30.0},
                options={"seed": seed},
            )
            with torch.no_grad():
                posterior = model.posterior(point)
                mean, std = float(posterior.mean[0, 0]), float(posterior.variance[0, 0].sqrt())
        u = np.clip(lo + point[0, :2].numpy() * (hi - lo), *bounds.T)
        return Proposal(u, "exploit" if -mean > std else "explore", bounds, -float(value), mean, std)
