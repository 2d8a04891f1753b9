"""Material in a user's terms, and the one place where it becomes PyBullet's numbers."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Interval, Lt


@dataclass(frozen=True)
class Material:
    """A homogeneous, isotropic, stable neo-Hookean solid. No plasticity, no fracture, no fibres."""

    youngs_modulus: Annotated[float, Interval(ge=1, le=1e12)]
    """E (Pa), at small strain."""
    poisson_ratio: Annotated[float, Ge(0), Lt(0.5)]
    """nu (-)."""
    friction: Annotated[float, Interval(ge=0.0, le=2.0)]
    """Coulomb coefficient between object and table (-)."""
    mass: Annotated[float, Interval(ge=1e-4, le=1000)] | None = None
    """Total mass (kg). Give either this or the density."""
    density: Annotated[float, Interval(ge=1, le=1e5)] | None = None
    """Density (kg/m^3)."""

    def __post_init__(self) -> None:
        if (self.mass is None) == (self.density is None):
            raise ValueError("mass: give either mass (kg) or density (kg/m^3), not both and not neither")

    @property
    def lame(self) -> tuple[float, float]:
        """Lame parameters (mu, lambda) in Pa: mu = E / 2(1+nu), lambda = E nu / (1+nu)(1-2nu)."""
        e, nu = self.youngs_modulus, self.poisson_ratio
        return e / (2 * (1 + nu)), e * nu / ((1 + nu) * (1 - 2 * nu))

    @property
    def bullet(self) -> tuple[float, float]:
        """PyBullet's (NeoHookeanMu, NeoHookeanLambda) in Pa.

        Bullet's stable neo-Hookean law is not re-parametrised: linearised at rest it behaves as
        mu' = 3/4 mu and lambda' = lambda - 5/8 mu. Inverted: mu = 4/3 mu', lambda = lambda' + 5/6 mu'.
        """
        mu, lam = self.lame
        return 4 / 3 * mu, lam + 5 / 6 * mu

    def total_mass(self, volume: float) -> float:
        """Mass (kg) of an object of this volume (m^3)."""
        return self.mass if self.mass is not None else self.density * volume  # type: ignore[operator]

    def scaled(self, stiffness: float, friction: float, mass: float) -> "Material":
        """The same material with E, friction and mass (or density) multiplied."""
        return Material(
            self.youngs_modulus * stiffness,
            self.poisson_ratio,
            self.friction * friction,
            None if self.mass is None else self.mass * mass,
            None if self.density is None else self.density * mass,
        )
