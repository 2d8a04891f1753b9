"""Separable space-time kernels, eq. (7): k(x, x') = sigma_f^2 k_s(u, u') k_t(t, t') with x = (kappa, d, t).

Inputs are model coordinates: kappa as it is, d scaled to the outer bounds, t in pushes. Hyper-parameters travel as
one vector theta = log(rho_kappa, rho_d, rho_t, sigma_f, noise) `(5,)`; sigma_f and noise are in units of the scaled xi.
"""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Literal, NamedTuple, Self

import numpy as np
from annotated_types import Ge, Gt, Interval

from deformpush.gp.profiles import MATERN32, MATERN52, OU, RBF, Profile

NAMES = ("rho_kappa", "rho_d", "rho_t", "sigma_f", "noise")


class Spatial(NamedTuple):
    """k_s and what its derivatives are made of."""

    k: np.ndarray
    w_kappa: np.ndarray
    """dk_s/dlog(rho_kappa) = w_kappa r_kappa^2; dk_s/dkappa = -w_kappa delta delta' / rho_kappa^2."""
    w_d: np.ndarray


@dataclass(frozen=True)
class Kernel:
    """Product of a spatial kernel with one length scale per coordinate and a time kernel."""

    rho_kappa: Annotated[float, Gt(0)] = 0.3
    """Length scale along the effective contour, as a fraction of it."""
    rho_d: Annotated[float, Gt(0)] = 0.5
    """Length scale of the pushing distance, as a fraction of d_max - d_min."""
    rho_t: Annotated[float, Gt(0)] = 20.0
    """Length scale of time (pushes)."""
    sigma_f: Annotated[float, Gt(0)] = 1.0
    """Standard deviation of the prior, in units of the root mean square of xi."""
    noise: Annotated[float, Gt(0)] = 0.15
    """Standard deviation of the noise, same units."""
    time: Literal["matern52", "ou", "tv", "window", "none"] = "matern52"
    """k_t: Matern 5/2; Ornstein-Uhlenbeck; TV-GP-UCB's (1 - eps)^(|dt|/2); last `window` pushes only; constant."""
    eps: Annotated[float, Interval(gt=0, lt=1)] = 0.03
    """Forgetting rate of `time: tv` (share of the function replaced per push)."""
    window: Annotated[int, Ge(1)] = 30
    """Pushes that `time: window` remembers."""
    kappa: Literal["auto", "open", "periodic"] = "auto"
    """Whether kappa = 0 and kappa = 1 are the same point; `auto`: when the effective contour is closed."""

    profile: ClassVar[Profile]

    def resolved(self, closed: bool) -> Self:
        """Return this kernel with `kappa: auto` settled for a closed or an open effective contour."""
        if self.kappa != "auto":
            return self
        return replace(self, kappa="periodic" if closed else "open")

    def theta(self) -> np.ndarray:
        """Log hyper-parameters `(5,)` as configured; for `time: tv` rho_t is tau = -2 / ln(1 - eps)."""
        rho_t = -2.0 / np.log1p(-self.eps) if self.time == "tv" else self.rho_t
        return np.log([self.rho_kappa, self.rho_d, rho_t, self.sigma_f, self.noise])

    def learnable(self) -> np.ndarray:
        """Which entries of theta the data can tell something about `(5,)` bool."""
        return np.array([True, True, self.time in ("matern52", "ou"), True, True])

    def remembers(self, t: np.ndarray, now: float) -> np.ndarray:
        """Which samples taken at times t `(S,)` count at time `now` (all, unless `time: window`)."""
        return t >= now - self.window if self.time == "window" else np.ones(len(t), bool)

    def prior_variance(self, theta: np.ndarray) -> float:
        """k(x, x)."""
        return float(np.exp(2.0 * theta[3]))

    def distances(self, X: np.ndarray) -> np.ndarray:
        """|delta| per coordinate for all pairs i > j of X `(S, 3)`: `(3, S(S-1)/2)`; the fit reuses them."""
        i, j = np.tril_indices(len(X), -1)
        delta = np.abs(X[i] - X[j]).T
        if self.kappa == "periodic":
            delta[0] = np.abs(_chord(delta[0]))
        return np.ascontiguousarray(delta)

    def gram(self, theta: np.ndarray, distances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Off-diagonal k `(P,)` and dk/dlog(rho_kappa, rho_d, rho_t) `(3, P)` for the pairs of `distances`."""
        r_kappa, r_d, r_t = distances * np.exp(-theta[:3])[:, None]
        k_t, q_t = self._temporal(r_t)
        spatial = self.spatial(r_kappa, r_d)
        k_t = k_t * np.exp(2.0 * theta[3])
        k = spatial.k * k_t
        slopes = np.stack([k_t * spatial.w_kappa * r_kappa**2, k_t * spatial.w_d * r_d**2, k * q_t * r_t**2])
        return k, slopes

    def temporal(self, theta: np.ndarray, dt: np.ndarray) -> np.ndarray:
        """k_t for time differences dt, any shape."""
        return self._temporal(np.abs(dt) * np.exp(-theta[2]))[0]

    def cross(self, theta: np.ndarray, U: np.ndarray, V: np.ndarray) -> np.ndarray:
        """k_s between U `(n, 2)` and V `(S, 2)`: `(n, S)`."""
        r_kappa, r_d = (np.abs(x) for x in self._scaled(theta, U, V)[:2])
        return self.values(r_kappa, r_d)

    def cross_gradient(
        self, theta: np.ndarray, U: np.ndarray, V: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """k_s `(n, S)` and its gradient with respect to U `(2, n, S)`."""
        a, b, bend = self._scaled(theta, U, V)
        k, w_kappa, w_d = self.spatial(np.abs(a), np.abs(b))
        inverse = np.exp(-theta[:2])
        return k, np.stack([-inverse[0] * w_kappa * a * bend, -inverse[1] * w_d * b])

    def values(self, r_kappa: np.ndarray, r_d: np.ndarray) -> np.ndarray:
        """k_s at scaled distances: the product g(r_kappa) g(r_d)."""
        (p, e), (p2, e2) = self.profile.parts(r_kappa), self.profile.parts(r_d)
        return p * p2 * np.exp(-(e + e2))

    def spatial(self, r_kappa: np.ndarray, r_d: np.ndarray) -> Spatial:
        """k_s at scaled distances with the weights of its derivatives."""
        k = self.values(r_kappa, r_d)
        return Spatial(k, k * self.profile.slope(r_kappa), k * self.profile.slope(r_d))

    def _temporal(self, r: np.ndarray) -> tuple[np.ndarray, np.ndarray | float]:
        if self.time in ("none", "window"):
            return np.ones_like(r), 0.0
        profile = MATERN52 if self.time == "matern52" else OU
        p, e = profile.parts(r)
        return p * np.exp(-e), profile.slope(r)

    def _scaled(
        self, theta: np.ndarray, U: np.ndarray, V: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray | float]:
        """Signed delta / rho of kappa and d `(n, S)`, and d delta / d kappa (1 unless periodic)."""
        delta = U[:, 0, None] - V[None, :, 0]
        bend: np.ndarray | float = 1.0
        if self.kappa == "periodic":
            delta, bend = _chord(delta), np.cos(np.pi * delta)
        inverse = np.exp(-theta[:2])
        return delta * inverse[0], (U[:, 1, None] - V[None, :, 1]) * inverse[1], bend


def _chord(delta: np.ndarray) -> np.ndarray:
    """sin(pi delta) / pi: straight distance on a circle of circumference 1, which is delta itself for near points.

    A circle lies in the plane, where Matern and Gaussian functions of the straight distance are positive definite.
    """
    return np.sin(np.pi * delta) / np.pi


@dataclass(frozen=True)
class Matern52(Kernel):
    """k_s = (1+a+a^2/3) e^-a (1+b+b^2/3) e^-b, a = sqrt(5)|dkappa|/rho_kappa, b = sqrt(5)|dd|/rho_d; see eq. (8)."""

    profile: ClassVar[Profile] = MATERN52


@dataclass(frozen=True)
class Matern32(Kernel):
    """k_s = (1+a) e^-a (1+b) e^-b, a = sqrt(3)|dkappa|/rho_kappa, b = sqrt(3)|dd|/rho_d: rougher."""

    profile: ClassVar[Profile] = MATERN32


@dataclass(frozen=True)
class SquaredExponential(Kernel):
    """k_s = exp(-dkappa^2 / (2 rho_kappa^2) - dd^2 / (2 rho_d^2)): infinitely smooth."""

    profile: ClassVar[Profile] = RBF


@dataclass(frozen=True)
class Matern52Sum(Kernel):
    """k_s = (1+a+a^2/3) e^-a + (1+b+b^2/3) e^-b: the sum that eq. (8) prints, with the misprints mended."""

    profile: ClassVar[Profile] = MATERN52

    def prior_variance(self, theta: np.ndarray) -> float:
        """k(x, x): both summands contribute sigma_f^2."""
        return 2.0 * super().prior_variance(theta)

    def values(self, r_kappa: np.ndarray, r_d: np.ndarray) -> np.ndarray:
        """k_s at scaled distances: the sum g(r_kappa) + g(r_d)."""
        (p, e), (p2, e2) = self.profile.parts(r_kappa), self.profile.parts(r_d)
        return p * np.exp(-e) + p2 * np.exp(-e2)

    def spatial(self, r_kappa: np.ndarray, r_d: np.ndarray) -> Spatial:
        """k_s at scaled distances with the weights of its derivatives."""
        (p, e), (p2, e2) = self.profile.parts(r_kappa), self.profile.parts(r_d)
        g, g2 = p * np.exp(-e), p2 * np.exp(-e2)
        return Spatial(g + g2, g * self.profile.slope(r_kappa), g2 * self.profile.slope(r_d))
