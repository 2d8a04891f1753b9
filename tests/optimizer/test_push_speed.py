"""The tool's speed under a limit: as fast as is gentle enough."""

import numpy as np
import pytest

from deformpush.optimizer import Safe

from .fragile_cases import CAREFUL, MADE_OF, optimizer, state, xi


def fast(u, v: float) -> float:
    """Strain of pushes that harm by their speed."""
    return 0.055 * (1.0 + 0.3 * np.cos(2 * np.pi * u[0])) * (1.0 + (v / 0.12) ** 2)


def test_speed_is_chosen_as_high_as_is_gentle_enough():
    exceeded, fastest, slowest_first = [], [], []
    for seed in range(4):
        safe = optimizer(Safe(limit=0.1, speed=(0.03, 0.15), fit=CAREFUL), seed)
        now, speeds = state(), []
        for _ in range(20):
            asked = safe.ask(now)
            assert 0.03 <= asked.speed <= 0.15
            then = state(fast(asked.u, asked.speed), asked.speed)
            safe.tell(asked.u, xi(asked.u), now, then)
            exceeded.append(then.strain > 0.1)
            speeds.append(asked.speed)
            now = then
        slowest_first.append(speeds[0] == 0.03)
        assert (
            np.diff(np.maximum.accumulate(speeds)) <= 0.5 * np.maximum.accumulate(speeds)[:-1] + 1e-9
        ).all()
        fastest.append(max(speeds))
    assert all(slowest_first)
    assert np.mean(exceeded) <= 0.05, "1 - p_safe"
    assert np.mean(fastest) > 0.06, "speed is used where it does no harm"


def test_the_fastest_allowed_speed_is_where_the_bound_meets_the_limit():
    model = Safe(limit=0.1, speed=(0.02, 0.15), p_speed=0.99, fit=CAREFUL).constraint(MADE_OF)
    U = np.random.default_rng(1).uniform(0, 1, (12, 2))
    for u, v in zip(U, np.linspace(0.02, 0.1, 12), strict=True):
        model.keep((fast(u, v), v))
    safe_set = model.feasible(U)
    inside = 0
    for u in U:
        v = safe_set.fastest(u)
        low, high = safe_set.speeds
        if low < v < high:
            inside += 1
            assert safe_set.probability(u, v) == pytest.approx(0.99, abs=1e-9)
    assert inside >= 3
