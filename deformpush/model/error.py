"""The paper's model: one Gaussian process on xi, the change of the total error."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from annotated_types import Interval

from deformpush.gp.regressor import MAX_FIT, MAX_KNOWN, Regressor
from deformpush.model.base import ModelComponents, Surface
from deformpush.model.rigid_push import RigidPush
from deformpush.state import State

Array = np.ndarray


@dataclass(frozen=True)
class ErrorModel:
    """xi ~ GP(mu_0, k) over (kappa, d, t). xi is divided by its root mean square, never centred.

    Centring would turn "forgotten" into "average", although an untried push is expected to change nothing.
    """

    max_fit: Annotated[int, Interval(ge=1, le=5000)] = MAX_FIT
    """Hyper-parameters are learnt from so many of the newest samples."""
    max_known: Annotated[int, Interval(ge=1, le=5000)] = MAX_KNOWN
    """Predictions are made from so many of the newest samples."""

    def learner(self, parts: ModelComponents) -> "ErrorLearner":
        """A learner that knows nothing yet.

        Raises:
            ValueError: the mean predicts motion, of which this model knows nothing.
        """
        if isinstance(parts.mean, RigidPush):
            raise ValueError("mean: rigid_push predicts how the object moves, it needs model=motion")
        return ErrorLearner(Regressor(parts.kernel, parts.mean, parts.fit, self.max_fit, self.max_known))


@dataclass(frozen=True, eq=False)
class XiPosterior:
    """The posterior of xi at the time of the next push."""

    surface: Surface
    noise: float
    """Standard deviation of what a repeated push would give."""
    info: dict[str, float] = field(default_factory=dict)

    def expected(self, u: Array) -> tuple[float, float]:
        """Mean and standard deviation of xi of push u `(2,)`."""
        mu, sigma = self.surface.predict(u[None])
        return float(mu[0]), float(sigma[0])

    def predictive(self, U: Array) -> tuple[Array, Array]:
        """Mean and standard deviation of xi `(n,)` of pushes U `(n, 2)`, noise included."""
        mu, sigma = self.surface.predict(U)
        return mu, np.hypot(sigma, self.noise)

    def forecast(self, u: Array) -> None:
        """Unknown: of the object's motion this model knows nothing."""

    def instead(self, u: Array, box: Array) -> tuple[None, dict[str, float]]:
        """Keep u, as Algorithm 2 does."""
        return None, {}


@dataclass(eq=False)
class ErrorLearner:
    """Learns from u and xi alone."""

    gp: Regressor
    least = 1

    def observe(self, u: Array, before: State | None, after: State | None) -> None:
        """U and xi suffice."""

    def keep(self, observed: None) -> None:
        """U and xi are kept by the optimizer."""

    def posterior(self, U: Array, xi: Array, state: State | None) -> XiPosterior:
        """Fit and condition."""
        S = len(xi)
        X = np.column_stack([U, np.arange(S, dtype=float)])
        posterior, info = self.gp.condition(X, xi, 0.0, float(S))
        return XiPosterior(posterior.at(float(S)), info["noise"] * info["scale"], info)

    def state(self) -> dict[str, Any]:
        """Hyper-parameters and how many samples they were fitted to."""
        theta, fitted = self.gp.state()
        return {"theta": theta, "fitted": fitted}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""
        self.gp.restore(state["theta"], state["fitted"])
