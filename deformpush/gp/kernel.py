"""Separable space-time kernels, eq. (7): k(x, x') = sigma_f^2 k_s(u, u') k_t(t, t') with x = (kappa, d, t).

Inputs are model coordinates: kappa as it is, d scaled to the outer bounds, t in pushes. Hyper-parameters
travel as one vector theta = log(rho_kappa, rho_d, rho_t, sigma_f, noise, ...) `(5 + L,)`; sigma_f and noise
are in units of the scaled xi, and L counts the further numbers that a `Correlation` learns. The two
space coordinates come first in arrays, `(2, ...)`, so that both are worked on at once.
"""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from annotated_types import Interval

from deformpush.gp.correlation import Correlation, LogNormal, slope
from deformpush.gp.cross_covariance import CrossCovariance, ProfileCrossCovariance
from deformpush.gp.profiles import MATERN32, MATERN52, OU, Array, ArrayOrFloat, Profile

BLOCK = 5000
"""Pairs worked on at a time: their arrays stay in the cache."""
NAMES = ("rho_kappa", "rho_d", "rho_t", "sigma_f", "noise")
"""Hyper-parameters that every kernel has."""


@dataclass(frozen=True)
class Kernel:
    """Product of a spatial kernel with one length scale per coordinate and a time kernel."""

    rho_kappa: Annotated[float, Interval(ge=1e-3, le=1e3)] = 0.3
    """Length scale along the effective contour, as a fraction of it."""
    rho_d: Annotated[float, Interval(ge=1e-3, le=1e3)] = 0.5
    """Length scale of the pushing distance, as a fraction of d_max - d_min."""
    rho_t: Annotated[float, Interval(ge=1e-3, le=1e6)] = 20.0
    """Length scale of time (pushes)."""
    sigma_f: Annotated[float, Interval(ge=1e-3, le=1e3)] = 1.0
    """Standard deviation of the prior, in units of the root mean square of xi."""
    noise: Annotated[float, Interval(ge=1e-4, le=1e3)] = 0.15
    """Standard deviation of the noise, same units."""
    time: Literal["matern52", "matern32", "ou", "tv", "window", "none"] | Correlation = "matern52"
    """k_t: Matern; Ornstein-Uhlenbeck; TV-GP-UCB's (1 - eps)^(|dt|/2); last `window` pushes; constant; or a
    formula of |dt| / rho_t."""
    eps: Annotated[float, Interval(ge=1e-6, lt=1)] = 0.03
    """Forgetting rate of `time: tv` (share of the function replaced per push)."""
    window: Annotated[int, Interval(ge=1, le=100_000)] = 30
    """Pushes that `time: window` remembers."""
    kappa: Literal["auto", "open", "periodic"] = "auto"
    """Whether kappa = 0 and kappa = 1 are the same point; `auto`: when the effective contour is closed."""

    profile: ClassVar[Profile]

    def __post_init__(self) -> None:
        """Check a time kernel that is given by its formula.

        Raises:
            ValueError: it is not 1 at distance 0.
        """
        if isinstance(self.time, Correlation):
            self.time.check("time", 1)

    @property
    def formulas(self) -> dict[str, Correlation]:
        """Those of its factors that are given by a formula alone, by field."""
        return {"time": self.time} if isinstance(self.time, Correlation) else {}

    @property
    def names(self) -> tuple[str, ...]:
        """Of the hyper-parameters in theta."""
        return *NAMES, *(f"{field}_{name}" for field, f in self.formulas.items() for name in f.learnt)

    @property
    def further_priors(self) -> list[LogNormal]:
        """Of the hyper-parameters beyond `NAMES`."""
        return [prior for formula in self.formulas.values() for prior in formula.learnt.values()]

    def resolved(self, closed: bool) -> Self:
        """Return this kernel with `kappa: auto` settled for a closed or an open effective contour."""
        if self.kappa != "auto":
            return self
        return replace(self, kappa="periodic" if closed else "open")

    def theta(self) -> Array:
        """Log hyper-parameters `(5 + L,)` as configured; for `time: tv` rho_t is tau = -2 / ln(1 - eps)."""
        rho_t = -2.0 / np.log1p(-self.eps) if self.time == "tv" else self.rho_t
        common = np.log([self.rho_kappa, self.rho_d, rho_t, self.sigma_f, self.noise])
        return np.append(common, [x for formula in self.formulas.values() for x in formula.log_values])

    def learnable(self) -> np.ndarray:
        """Which entries of theta the data can tell something about `(5 + L,)` bool."""
        drifts = self.time in ("matern52", "matern32", "ou") or "time" in self.formulas
        return np.array([True, True, drifts, True, True, *(True for _ in self.further_priors)])

    def formula(self, field: str, theta: Array) -> Correlation:
        """The formula of a factor, with what it learns as in theta."""
        first = len(NAMES)
        for name, formula in self.formulas.items():
            last = first + len(formula.learnt)
            if name == field:
                return formula.at(theta[first:last])
            first = last
        raise KeyError(field)

    def remembers(self, t: Array, now: float) -> np.ndarray:
        """Which samples taken at times t `(S,)` count at time `now` (all, unless `time: window`)."""
        return t >= now - self.window if self.time == "window" else np.ones(len(t), bool)

    def prior_variance(self, theta: Array) -> float:
        """k(x, x)."""
        return float(np.exp(2.0 * theta[3]))

    def distances(self, X: Array) -> Array:
        """|delta| per coordinate for all pairs i > j of X `(S, 3)`: `(3, S(S-1)/2)`; the fit reuses them."""
        i, j = np.tril_indices(len(X), -1)
        return self.apart(X.T[:, i] - X.T[:, j])

    def apart(self, delta: Array) -> Array:
        """Distances along each coordinate of differences `(2 or 3, ...)`: straight ones on a circle."""
        delta = np.abs(delta)
        if self.kappa == "periodic":
            delta[0] = np.abs(_chord(delta[0]))
        return delta

    def gram(self, theta: Array, distances: Array) -> Array:
        """K `(P,)` for the pairs of `distances`, without the noise."""
        a = distances * self.rates(theta)[:, None]
        k = self.values(theta, a[:2])
        k *= self._time_values(theta, a[2]) * np.exp(2.0 * theta[3])
        return k

    def gram_gradient(self, theta: Array, distances: Array, out: Array) -> tuple[Array, Array]:
        """K `(P,)` and its derivatives by theta, but for sigma_f and noise, `(3 + L, P)`.

        Both are views of `out` `(4 + L, P)`, which a fit allocates once: fresh large arrays cost more than
        the sums.
        """
        if self.formulas:
            return self._gram_differences(theta, distances, out)
        rates, variance = self.rates(theta)[:, None], np.exp(2.0 * theta[3])
        for i in range(0, distances.shape[1], BLOCK):
            part = slice(i, i + BLOCK)
            a = distances[:, part] * rates
            k, w = self.spatial(a[:2])
            k_t, q_t = self._temporal(a[2])
            k_t *= variance
            k *= k_t
            w *= k_t
            a *= a
            out[0, part] = k
            np.multiply(a[:2], w, out=out[1:3, part])
            np.multiply(a[2], q_t * k, out=out[3, part])
        return out[0], out[1:]

    def _gram_differences(self, theta: Array, distances: Array, out: Array) -> tuple[Array, Array]:
        """As `gram_gradient`, from `gram` alone."""
        out[0] = self.gram(theta, distances)
        for row, along in zip(out[1:], np.delete(np.eye(len(theta)), (3, 4), axis=0), strict=True):
            row[:] = slope(lambda x: self.gram(x, distances), theta, along)
        return out[0], out[1:]

    def cross_covariance(self, theta: Array, V: Array) -> CrossCovariance:
        """k_s between samples V `(S, 2)` and any pushes."""
        return ProfileCrossCovariance(self, theta, V)

    def temporal(self, theta: Array, dt: Array) -> Array:
        """k_t for time differences dt, any shape."""
        return self._time_values(theta, np.abs(dt) * self.rates(theta)[2])

    def values(self, theta: Array, a: Array) -> Array:
        """k_s at scaled distances a `(2, ...)`: the product g(a_kappa) g(a_d)."""
        p, e = self.profile.parts(a)
        return _product(p, e)

    def spatial(self, a: Array) -> tuple[Array, Array]:
        """k_s at scaled distances a `(2, ...)`, and weights w `(2, ...)` of its derivatives.

        dk_s/dlog(rho_i) = w_i a_i^2 and dk_s/dx_i = -w_i a_i rate / rho_i, a_i signed.
        """
        p, e, q = self.profile.full(a)
        k = _product(p, e)
        return k, q * k if isinstance(q, np.ndarray) else np.stack([k, k])

    def embed(self, X: Array) -> Array:
        """X `(S, 3)` where the kernel is stationary `(S, E)`: kappa, d, t; or a circle's x, y, then d, t."""
        if self.kappa != "periodic":
            return X
        angle = 2.0 * np.pi * X[:, 0]
        return np.column_stack([np.cos(angle) / (2.0 * np.pi), np.sin(angle) / (2.0 * np.pi), X[:, 1:]])

    def embedded_gradient(self, U: Array, by_embedding: Array) -> Array:
        """Gradient with respect to U `(n, 2)` from that with respect to `embed`'s coordinates `(n, E)`."""
        if self.kappa != "periodic":
            return by_embedding[:, :2]
        angle = 2.0 * np.pi * U[:, 0]
        along = by_embedding[:, 1] * np.cos(angle) - by_embedding[:, 0] * np.sin(angle)
        return np.column_stack([along, by_embedding[:, 2]])

    def frequencies(self, theta: Array, n: int, rng: np.random.Generator) -> Array:
        """N draws `(n, E)` from the kernel's spectral density over `embed`'s coordinates.

        Student's t in the plane of a periodic kappa shares its divisor between the two coordinates; so it
        does not for kappa, d and t, which are separable.
        """
        planar = 2 if self.kappa == "periodic" else 1
        time = self._time
        return np.hstack(
            [
                self.profile.frequencies((n, planar), rng) * np.exp(-theta[0]),
                self.profile.frequencies((n, 1), rng) * np.exp(-theta[1]),
                time.frequencies((n, 1), rng) * np.exp(-theta[2]) if time else np.zeros((n, 1)),
            ]
        )

    def _time_values(self, theta: Array, a: Array) -> Array:
        if "time" in self.formulas:
            return self.formula("time", theta)(a)
        return self._temporal(a)[0]

    def _temporal(self, a: Array) -> tuple[Array, ArrayOrFloat]:
        if self._time is None:
            return np.ones_like(a), 0.0
        p, e, q = self._time.full(a)
        return p * np.exp(-e), q

    @property
    def _time(self) -> Profile | None:
        if isinstance(self.time, Correlation):
            return None
        return {"matern52": MATERN52, "matern32": MATERN32, "ou": OU, "tv": OU}.get(self.time)

    @property
    def space_rate(self) -> float:
        """What k_s multiplies distances over length scales with."""
        return self.profile.rate

    def rates(self, theta: Array) -> Array:
        """What turns distances into scaled distances `(3,)`."""
        space, time = self.space_rate, self._time.rate if self._time else 1.0
        return np.array([space, space, time]) * np.exp(-theta[:3])


def _product(p: ArrayOrFloat, e: Array) -> Array:
    k: Array = e[0] + e[1]
    np.negative(k, out=k)
    np.exp(k, out=k)
    if isinstance(p, np.ndarray):
        k *= p[0]
        k *= p[1]
    return k


def _chord(delta: Array) -> Array:
    """sin(pi delta) / pi: straight distance on a circle of circumference 1, about delta for near points.

    A circle lies in the plane, where Matern and Gaussian functions of the straight distance are positive
    definite.
    """
    return np.asarray(np.sin(np.pi * delta) / np.pi)
