"""Decisions do not hang on the last bit of what was told, of what was seen, or of a sum on the way."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.model.motion import MotionModel
from deformpush.model.rigid_push import RigidPush
from deformpush.optimizer import ABO, Adaptive, Components
from deformpush.optimizer.acquisition import LCB, Acquisition
from deformpush.optimizer.safe import SafeLCB
from tests.states import known, observed, seen

SAFE = SafeLCB(limit=0.08)


def made(motion: bool, acquisition: Acquisition) -> ABO:
    bounds = Adaptive(kappa=(0.0, 1.0), d=(0.01, 0.03))
    parts = Components(bounds, np.random.default_rng(0), closed=True, acquisition=acquisition)
    if motion:
        parts = replace(parts, model=MotionModel(), mean=RigidPush())
    return ABO(S0=0 if motion else 4, parts=parts)


def noisy(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return x * (1.0 + 1e-15 * rng.uniform(-1, 1, np.shape(x)))


@pytest.mark.parametrize("motion", [False, True], ids=["error", "motion"])
@pytest.mark.parametrize("acquisition", [LCB(), SAFE], ids=["lcb", "safe_lcb"])
def test_two_optimizers_told_the_same_but_for_noise_ask_for_the_same_pushes(motion, acquisition):
    world, noise = np.random.default_rng(1), np.random.default_rng(2)
    one, other = made(motion, acquisition), made(motion, acquisition)
    now = again = replace(seen(), strain=None, speed=None)
    for _ in range(14):
        a, b = one.ask(now), other.ask(again)
        assert a.u.tolist() == b.u.tolist()
        assert a.speed == b.speed
        np.testing.assert_equal(a.reported().mean, b.reported().mean)
        assert a.bounds.tolist() == b.bounds.tolist()
        angle = 2 * np.pi * a.u[0]
        c = now.seen.c + 0.7 * a.u[1] * np.array([np.sin(angle), -np.cos(angle)])
        then = seen(*(c + 5e-4 * world.normal(size=2)), now.seen.theta + 0.03 * world.normal())
        then = replace(then, strain=float(0.05 + 0.02 * world.uniform()), speed=a.speed)
        look = observed(noisy(then.seen.contour, noise), noisy(then.seen.c, noise), then.seen.theta)
        then_again = replace(known(look), strain=float(noisy(np.array(then.strain), noise)), speed=b.speed)
        one.tell(a.u, then.errors.e_T - now.errors.e_T, now, then)
        other.tell(b.u, then_again.errors.e_T - again.errors.e_T, again, then_again)
        now, again = then, then_again
