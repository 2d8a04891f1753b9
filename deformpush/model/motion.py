"""The motion model: one Gaussian process per outcome of a push, composed with the known error (1)-(4)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from annotated_types import Interval

from deformpush.gp.means import Zero
from deformpush.gp.regressor import MAX_FIT, MAX_KNOWN, Regressor
from deformpush.mechanics.geometry import gyration, rotation
from deformpush.model.base import ModelComponents, Surface
from deformpush.model.coordinates import share_of_longest
from deformpush.model.error_of_motion import ErrorOfMotion, pose
from deformpush.model.motion_posterior import MotionPosterior
from deformpush.model.outcomes import OutcomeField, Unlearnt
from deformpush.model.rigid_push import Experience, RigidPush
from deformpush.state import State

Array = np.ndarray

OUTLYING = 0.3
"""Residuals of the rigid body count linearly beyond this share of the scale of their outcome."""


@dataclass(frozen=True)
class MotionModel:
    """Four processes over (kappa, d, t): displacement of the centroid in the object's frame, turn, shape.

    Each learns its outcome per length of push, in units of what the longest push might do.

    What is learnt of them stays true when the object lies elsewhere; what follows for the error is computed,
    not learnt.
    """

    samples: Annotated[int, Interval(ge=2, le=4096)] = 64
    """Monte Carlo draws of the outcomes, the same for all pushes that are compared."""
    lookahead: Literal[1, 2] = 1
    """Pushes planned ahead; with 2 an eighth of the draws, each with the best of 48 pushes after it."""
    shape_scale: Annotated[float, Interval(ge=1e-4, le=10)] = 0.03
    """By how much a push may change the shape error (3): scale of its process."""
    max_fit: Annotated[int, Interval(ge=1, le=5000)] = MAX_FIT
    """Hyper-parameters are learnt from so many of the newest samples."""
    max_known: Annotated[int, Interval(ge=1, le=5000)] = MAX_KNOWN
    """Predictions are made from so many of the newest samples."""

    def learner(self, parts: ModelComponents) -> "MotionLearner":
        """A learner that knows nothing yet."""
        return MotionLearner(self, parts)


class Observed(NamedTuple):
    """What is kept of a push."""

    y: Array
    """Its outcome `(4,)`."""
    before: State
    after: State
    rigid: tuple[Array, float] | None
    """What rigid bodies would have done; None without that prior mean."""


class MotionLearner:
    """Learns from the states before and after each push."""

    def __init__(self, spec: MotionModel, parts: ModelComponents) -> None:
        """Knows nothing yet."""
        self.spec, self.outer, self.closed = spec, parts.outer, parts.closed
        self.rigid: Experience | None = None
        mean = parts.mean
        if isinstance(mean, RigidPush):
            self.rigid, mean = Experience(mean, float(parts.outer[1, 1]), spec.max_known), Zero()
        self.least = 0 if self.rigid else 1
        self.gps = [Regressor(parts.kernel, mean, parts.fit, spec.max_fit, spec.max_known) for _ in range(4)]
        self.Y = np.empty((0, 4))
        """Outcomes `(S, 4)`."""
        self._scale: Array | None = None
        self._latest: State | None = None

    def observe(self, u: Array, before: State | None, after: State | None) -> Observed:
        """The outcome of push u, and what rigid bodies would have done.

        Raises:
            ValueError: a state is missing.
        """
        if before is None or after is None:
            raise ValueError("tell: model=motion learns from states, call tell(u, xi, before, after)")
        y = pose(after) - pose(before)
        y[:2] = rotation(-before.seen.theta) @ y[:2]
        if not np.isfinite(y).all():
            raise ValueError(f"tell: the states before and after differ by {y.tolist()}, which is not finite")
        rigid = self.rigid.table(before, np.asarray(u, float)) if self.rigid else None
        return Observed(y, before, after, rigid)

    def keep(self, observed: Observed) -> None:
        """Append one outcome."""
        self._scales(observed.before)
        self._latest = observed.after
        self.Y = np.vstack([self.Y, observed.y])
        if self.rigid and observed.rigid:
            self.rigid.keep(*observed.rigid)

    def posterior(self, U: Array, xi: Array, state: State | None) -> MotionPosterior:
        """Fit and condition; without a state for the object as it was seen last.

        Raises:
            ValueError: the object was never seen.
        """
        state = self._latest if state is None else state
        if state is None:
            raise ValueError("state: model=motion must see the object, call ask(state)")
        scale = self._scales(state)
        S, info = len(U), {}
        prior, field = np.zeros((S, 4)), None
        if self.rigid:
            if S:
                self.rigid.learn(self.Y[:, :3], OUTLYING * scale[:3])
                means = self.rigid.means()
                prior[S - len(means) :, :3] = means
            field = self.rigid.field(state, self.outer, self.closed)
            info = {"slip": self.rigid.slip, "pressure_radius": self.rigid.pressure}
        surfaces: list[Surface] = []
        noise = np.zeros(4)
        share = share_of_longest(U, self.outer[1])
        X = np.column_stack([U, np.arange(S, dtype=float)])
        for j, gp in enumerate(self.gps):
            if not S:
                surfaces.append(Unlearnt(float(scale[j])))
                continue
            rest = (self.Y[:, j] - prior[:, j]) / share
            posterior, found = gp.condition(X, rest, float(scale[j]), float(S))
            surfaces.append(posterior.at(float(S)))
            noise[j] = found["noise"] * scale[j]
        outcomes = OutcomeField(surfaces, field, noise, self.outer[1])
        one = ErrorOfMotion(state, self.spec.samples)
        if self.spec.lookahead == 1:
            return MotionPosterior(state, outcomes, one, one, info)
        two = ErrorOfMotion(state, max(4, self.spec.samples // 8), outcomes.mean_grid())
        return MotionPosterior(state, outcomes, one, two, info)

    def state(self) -> dict[str, Any]:
        """Outcomes, hyper-parameters, and what rigid bodies would have done."""
        theta, fitted = zip(*(gp.state() for gp in self.gps), strict=True)
        scale = np.full(4, np.nan) if self._scale is None else self._scale
        return {
            "Y": self.Y.copy(),
            "theta": np.array(theta),
            "fitted": np.array(fitted),
            "y_scale": scale.copy(),
        } | (self.rigid.state() if self.rigid else {})

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned."""
        self.Y = np.array(state["Y"], float).reshape(-1, 4)
        for gp, theta, fitted in zip(self.gps, state["theta"], state["fitted"], strict=True):
            gp.restore(theta, fitted)
        self._scale = None if np.isnan(state["y_scale"]).any() else np.array(state["y_scale"], float)
        self._latest = None
        if self.rigid:
            self.rigid.restore(state)

    def _scales(self, state: State) -> Array:
        """Scales of the outcomes `(4,)`, from the first outline seen: what the longest push might do."""
        if self._scale is None:
            d_max = float(self.outer[1, 1])
            moves = np.array([d_max, d_max, d_max / gyration(state.seen.contour - state.seen.c)])
            if self.rigid:
                moves *= self.rigid.spec.deviation
            self._scale = np.append(moves, self.spec.shape_scale)
        return self._scale
