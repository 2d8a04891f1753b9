"""A made-up object that long pushes harm, shared by the tests of pushing under a limit."""

from dataclasses import replace

import numpy as np

from deformpush.gp.fit import MAP
from deformpush.gp.kernels import Matern52
from deformpush.gp.means import Zero
from deformpush.mechanics.outline_change import contour_change
from deformpush.model.base import ModelComponents
from deformpush.optimizer import ABO, Components
from deformpush.optimizer.bounds import Box
from deformpush.state import State
from tests.states import seen

D = (0.01, 0.03)
AROUND = np.linspace(-np.pi, np.pi, 256, endpoint=False)
DISC = 0.06 * np.column_stack([np.cos(AROUND), np.sin(AROUND)])
OUTER = np.array([[0.0, 1.0], D])
MADE_OF = ModelComponents(Matern52().resolved(True), Zero(), MAP(), OUTER, True)
CAREFUL = MAP(
    rho_kappa=(0.15, 2.0), rho_d=(0.5, 2.0), rho_t=(30.0, 2.0), noise=(0.3, 2.0), sigma_f=(1.0, 1.6)
)


def peak(u) -> float:
    """Strain of a made-up object: long pushes near kappa = 0.5 harm it."""
    kappa, d = u
    return 0.05 * (d / 0.01) ** 0.6 * (1.0 + 0.6 * np.cos(2 * np.pi * (kappa - 0.5)))


def xi(u) -> float:
    """And just those help most."""
    kappa, d = u
    return -30.0 * d * np.cos(2 * np.pi * (kappa - 0.45))


def state(strain: float | None = None, speed: float | None = None) -> State:
    """An object whose outline, under the tool, has a dent in proportion to the strain."""
    pressed = () if strain is None else (DISC, dented(strain))
    return replace(seen(), e_T_share=1.0, strain=strain, speed=speed, pressed=pressed, at_rest=DISC)


def dented(strain: float) -> np.ndarray:
    return DISC * (1.0 - 0.5 * strain * np.exp(-8.0 * AROUND**2))[:, None]


GAIN = 0.1 / contour_change(DISC, dented(0.1)).dent


def optimizer(acquisition, seed: int = 0, S0: int = 5) -> ABO:
    parts = Components(bounds=Box(d=D), rng=np.random.default_rng(seed), closed=True, acquisition=acquisition)
    return ABO(S0=S0, parts=parts)
