"""A decision after thousands of pushes takes no longer than after hundreds."""

from time import process_time

import numpy as np
import pytest

from deformpush.model.motion import MotionModel
from deformpush.model.rigid_push import RigidPush
from deformpush.optimizer import ABO, Adaptive, Components
from tests.states import seen

PUSHES = 2000
BOUNDS = Adaptive(kappa=(0.0, 1.0), d=(0.01, 0.03))


def tell(optimizer: ABO, rng: np.random.Generator, pushes: int) -> None:
    now = seen()
    for _ in range(pushes):
        u = rng.uniform((0.0, 0.01), (1.0, 0.03))
        angle = 2 * np.pi * u[0]
        c = np.clip(now.seen.c + 0.7 * u[1] * np.array([np.sin(angle), -np.cos(angle)]), -0.2, 0.2)
        then = seen(*(c + 5e-4 * rng.normal(size=2)), now.seen.theta + 0.03 * rng.normal())
        optimizer.tell(u, then.errors.e_T - now.errors.e_T, now, then)
        now = then


@pytest.mark.parametrize(
    "motion",
    [pytest.param(False, id="error"), pytest.param(True, id="motion", marks=pytest.mark.slow)],
)
def test_a_decision_after_2000_pushes_takes_under_a_second(motion):
    rng = np.random.default_rng(0)
    parts = Components(BOUNDS, np.random.default_rng(0), closed=True)
    if motion:
        parts = Components(
            BOUNDS, np.random.default_rng(0), closed=True, model=MotionModel(), mean=RigidPush()
        )
    optimizer = ABO(S0=0, parts=parts) if motion else ABO(S0=4, parts=parts)
    tell(optimizer, rng, PUSHES)
    optimizer.ask(seen())  # the first fit starts cold, and libraries are loaded
    took = []
    for _ in range(3):
        tell(optimizer, rng, 1)
        began = process_time()
        proposal = optimizer.ask(seen())
        took.append(process_time() - began)
    assert min(took) < 1.0
    if not motion:
        assert proposal.info["samples"] == 300
    kept = optimizer.state()
    assert len(kept["U"]) == PUSHES + 3
    assert kept.get("rigid_tables", np.empty((300,))).shape[0] == 300


def test_motion_is_predicted_from_the_newest_pushes_and_their_own_priors():
    """With room for all, and with room for fewer than there are, the newest hardly differ."""
    found = []
    for room in (60, 30):
        parts = Components(
            BOUNDS, np.random.default_rng(0), closed=True, model=MotionModel(max_known=room), mean=RigidPush()
        )
        optimizer = ABO(S0=0, parts=parts)
        tell(optimizer, np.random.default_rng(1), 55)
        found.append(optimizer.ask(seen()))
    for name in ("slip", "pressure_radius"):
        assert found[0].info[name] == found[1].info[name]
    np.testing.assert_allclose(found[0].forecast.mean, found[1].forecast.mean, atol=5e-3)
