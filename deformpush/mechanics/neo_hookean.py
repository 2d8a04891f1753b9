"""The elastic law of the engine: stresses and energy of the stable neo-Hookean solid that Bullet integrates.

Per volume of the undeformed body, with I_C = tr(F'F) and J = det F,

    Psi = mu/2 (I_C - 3) - mu/2 ln((I_C + 1) / 4) + lambda/2 (J - 1)^2 - 3/4 mu (J - 1),

which is law (14) of Smith, de Goes and Kim, "Stable Neo-Hookean Flesh Simulation", ACM TOG 37(2), 2018, with
their alpha multiplied out and the constant chosen so that Psi = 0 at rest. mu and lambda are the numbers that
Bullet is given (`deformpush.mechanics.material.Material.bullet`), not Lame's. The damping force is not in it.
"""

from dataclasses import dataclass

import numpy as np

from deformpush.mechanics.material import Material

Array = np.ndarray


@dataclass(frozen=True)
class NeoHookean:
    """Stresses (Pa) and energy (J/m^3) of deformation gradients F `(..., 3, 3)`."""

    mu: float
    """Bullet's NeoHookeanMu (Pa)."""
    lam: float
    """Bullet's NeoHookeanLambda (Pa)."""

    @classmethod
    def of(cls, material: Material) -> "NeoHookean":
        """The law as the engine applies it to this material."""
        return cls(*material.bullet)

    def piola(self, F: Array) -> Array:
        """First Piola stress P = dPsi/dF `(..., 3, 3)`: force over undeformed area."""
        trace = np.sum(F**2, axis=(-2, -1))[..., None, None]
        J = np.linalg.det(F)[..., None, None]
        return np.asarray(
            self.mu * (1 - 1 / (trace + 1)) * F + (self.lam * (J - 1) - 0.75 * self.mu) * cofactor(F)
        )

    def cauchy(self, F: Array) -> Array:
        """Cauchy stress P F' / J `(..., 3, 3)`: force over deformed area."""
        return np.asarray(self.piola(F) @ np.swapaxes(F, -1, -2) / np.linalg.det(F)[..., None, None])

    def energy(self, F: Array) -> Array:
        """Strain energy density Psi `(...)`."""
        trace, grown = np.sum(F**2, axis=(-2, -1)), np.linalg.det(F) - 1
        shape = self.mu / 2 * (trace - 3 - np.log((trace + 1) / 4))
        return np.asarray(shape + self.lam / 2 * grown**2 - 0.75 * self.mu * grown)


def von_mises(stress: Array) -> Array:
    """Von Mises stress sqrt(3/2 s:s) of Cauchy stresses `(..., 3, 3)`, s their deviator."""
    mean = np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3
    deviator = stress - mean * np.eye(3)
    return np.asarray(np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1))))


def cofactor(F: Array) -> Array:
    """Cofactor J F^-T `(..., 3, 3)`: the cross products of the columns, so it holds at J = 0 too."""
    a, b, c = (F[..., :, i] for i in range(3))
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
