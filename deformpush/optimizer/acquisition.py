"""Acquisition functions: all are minimised, over u = (kappa, d) at the time of the next push.

mu and sigma are the posterior (10)-(11) of xi there; lower xi is better. Improvement counts from `best`,
the lowest posterior mean now at the pushes tried so far: raw minima would be noisy, and old ones out of
date.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from annotated_types import Interval

from deformpush.cell.world import Capability
from deformpush.gp.profiles import Array
from deformpush.model.base import ModelComponents, Surface
from deformpush.optimizer.constraint import Constraint, Feasible, Unconstrained
from deformpush.optimizer.objective import Objective, OverSurface, Partials


@dataclass(frozen=True, eq=False)
class Context:
    """What an acquisition may look at."""

    surface: Surface
    tried: Array
    """Pushes made so far `(S, 2)`, model coordinates."""
    t: int
    """Number of pushes made so far."""
    rng: np.random.Generator
    feasible: Feasible = field(default_factory=Unconstrained)
    """Which pushes are allowed, by the acquisition's constraint."""

    def best(self) -> float:
        """Lowest posterior mean now at the pushes tried so far; 0, no change, before the first."""
        if not len(self.tried):
            return 0.0
        return float(self.surface.predict(self.tried)[0].min())


class Acquisition(ABC):
    """Turns the posterior into a function to minimise. `objective` is all it takes."""

    @property
    def needs(self) -> frozenset[Capability]:
        """What the world must offer: nothing that only some worlds have."""
        return frozenset()

    def constraint(self, parts: ModelComponents) -> Constraint:
        """What limits the pushes: nothing."""
        return Unconstrained()

    @abstractmethod
    def objective(self, context: Context) -> Objective:
        """Prepare the function for one decision."""


def lower_confidence(mu: Array, sigma: Array, w: float) -> Partials:
    """Mu - w sigma."""
    return Partials(mu - w * sigma, np.ones_like(mu), np.full_like(mu, -w))


def negative_log_ei(mu: Array, sigma: Array, best: float) -> Partials:
    """-log(sigma h(z)), h(z) = phi(z) + z Phi(z), z = (best - mu) / sigma; exact however small EI is."""
    z = (best - mu) / sigma
    mills = _mills(np.minimum(z, -1.0))
    low = np.minimum(z, -1.0)
    # h / phi = 1 + z Phi / phi cancels far out; there its series 1/z^2 - 3/z^4 + 15/z^6 has 12 digits right.
    far = 1.0 / np.square(np.minimum(z, -200.0))
    ratio = np.where(z < -200.0, far * (1.0 - far * (3.0 - 15.0 * far)), 1.0 + low * mills)
    high = np.maximum(z, -1.0)
    phi, cdf = np.exp(_log_phi(high)), _cdf(high)
    h = phi + high * cdf
    log_h = np.where(z < -1.0, _log_phi(z) + np.log(ratio), np.log(h))
    by_mu = np.where(z < -1.0, mills / ratio, cdf / h) / sigma
    by_sigma = -np.where(z < -1.0, 1.0 / ratio, phi / h) / sigma
    return Partials(-np.log(sigma) - log_h, by_mu, by_sigma)


def negative_log_pi(mu: Array, sigma: Array, best: float) -> Partials:
    """-log Phi(z), z = (best - mu) / sigma."""
    from scipy.special import log_ndtr

    z = (best - mu) / sigma
    high = np.maximum(z, 0.0)
    hazard = np.where(z < 0.0, 1.0 / _mills(np.minimum(z, 0.0)), np.exp(_log_phi(high)) / _cdf(high))
    return Partials(-log_ndtr(z), hazard / sigma, z * hazard / sigma)


def _log_phi(z: Array) -> Array:
    return np.asarray(-0.5 * z * z - 0.5 * np.log(2.0 * np.pi))


def _cdf(z: Array) -> Array:
    from scipy.special import ndtr

    return np.asarray(ndtr(z))


def _mills(z: Array) -> Array:
    """Phi(z) / phi(z) for z <= 0."""
    from scipy.special import erfcx

    return np.asarray(np.sqrt(np.pi / 2.0) * erfcx(-z / np.sqrt(2.0)))


@dataclass(frozen=True)
class LCB(Acquisition):
    """LCB(x) = mu(x) - w sigma(x), eq. (12) (Cox & John 1992). w = 0 exploits only."""

    w: Annotated[float, Interval(ge=0, le=1e6)] = 2.0

    def objective(self, context: Context) -> Objective:
        """The bound over the surface of now."""
        return OverSurface(context.surface, lambda mu, sigma: lower_confidence(mu, sigma, self.w))


@dataclass(frozen=True)
class LCBSchedule(Acquisition):
    """mu(x) - sqrt(beta_t) sigma(x), beta_t = c1 ln(c2 t) (Srinivas et al. 2010, Bogunovic et al. 2016)."""

    c1: Annotated[float, Interval(ge=0, le=1e6)] = 0.8
    c2: Annotated[float, Interval(ge=1e-6, le=1e6)] = 4.0

    def objective(self, context: Context) -> Objective:
        """The bound with the weight of push t."""
        w = float(np.sqrt(max(0.0, self.c1 * np.log(max(self.c2 * context.t, 1e-300)))))
        return OverSurface(context.surface, lambda mu, sigma: lower_confidence(mu, sigma, w))


@dataclass(frozen=True)
class EI(Acquisition):
    """EI(x) = E[max(best - margin - f(x), 0)] = sigma (phi(z) + z Phi(z)), z = (best - margin - mu) / sigma.

    Mockus 1978, Jones et al. 1998. What is minimised, and reported, is -log EI: it has the same place and a
    gradient far from the data too (Ament et al. 2023).
    """

    margin: Annotated[float, Interval(ge=0, le=1000)] = 0.0

    def objective(self, context: Context) -> Objective:
        """-log EI below the best of now."""
        best = context.best() - self.margin
        return OverSurface(context.surface, lambda mu, sigma: negative_log_ei(mu, sigma, best))


@dataclass(frozen=True)
class PI(Acquisition):
    """PI(x) = P(f(x) < best - margin) = Phi(z), z = (best - margin - mu) / sigma (Kushner 1964).

    What is minimised, and reported, is -log PI.
    """

    margin: Annotated[float, Interval(ge=0, le=1000)] = 0.01

    def objective(self, context: Context) -> Objective:
        """-log PI below the best of now."""
        best = context.best() - self.margin
        return OverSurface(context.surface, lambda mu, sigma: negative_log_pi(mu, sigma, best))


@dataclass(frozen=True)
class Thompson(Acquisition):
    """f(x), one function drawn from the posterior (9) (Thompson 1933).

    The draw is a smooth function (pathwise conditioning, Wilson et al. 2020), so the same minimiser applies.
    """

    features: Annotated[int, Interval(ge=1, le=100_000)] = 1024
    """Random Fourier features of the prior draw (Rahimi & Recht 2007); its error falls with their root."""

    def objective(self, context: Context) -> Objective:
        """One draw, the same for all calls of this decision."""
        return context.surface.draw(self.features, context.rng)
