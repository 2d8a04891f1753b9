"""The set of pushes that are gentle enough: its bound, its wall, and the push that is made where none is."""

from dataclasses import dataclass

import numpy as np
import pytest

from deformpush.optimizer.safe import Safe
from deformpush.optimizer.safe_set import SafeSet, Walled

from .fragile_cases import CAREFUL, MADE_OF, OUTER, D, peak


def learnt(n: int = 8, **settings):
    """A strain model after n pushes, and the pushes in model coordinates."""
    model = Safe(limit=0.1, fit=CAREFUL, **settings).constraint(MADE_OF)
    U = np.random.default_rng(1).uniform(0, 1, (n, 2))
    for u in U:
        model.keep((peak((u[0], D[0] + u[1] * (D[1] - D[0]))), 0.0))
    return model, U


def test_the_gradient_is_that_of_the_constraint():
    model, U = learnt()
    safe_set = model.feasible(U)
    at = np.random.default_rng(2).uniform(0.05, 0.95, (20, 2))
    value, slope = safe_set.gradient(at)
    np.testing.assert_allclose(value, safe_set.constraint(at))
    for j in range(2):
        step = np.eye(2)[j] * 1e-6
        numeric = (safe_set.constraint(at + step) - safe_set.constraint(at - step)) / 2e-6
        np.testing.assert_allclose(slope[:, j], numeric, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("p_safe", [0.8, 0.95, 0.99])
def test_allowed_means_probable_enough(p_safe):
    model, U = learnt(p_safe=p_safe)
    safe_set = model.feasible(U)
    for u in np.random.default_rng(3).uniform(0, 1, (50, 2)):
        assert (safe_set.constraint(u[None])[0] <= 0) == (safe_set.probability(u, 0.0) >= p_safe)


def test_the_probability_counts_what_a_repeated_push_would_scatter():
    model, U = learnt(n=40)
    safe_set = model.feasible(U)
    assert safe_set.noise > 0
    mu, _ = safe_set.peak(U[:1])
    _, sigma = safe_set.learnt.predict(U[:1], safe_set.trend.basis(1, 0.0))
    assert safe_set.constraint(U[:1])[0] == pytest.approx(
        mu[0] + safe_set.z * np.hypot(sigma[0], safe_set.noise) - np.log(0.1)
    )


def test_of_the_shortest_pushes_it_is_known_what_is_expected():
    model, U = learnt(n=3)
    safe_set = model.feasible(U)
    shortest, over = safe_set.shortest(np.array([[0.0, 1.0], [0.0, 1.0]]))
    assert (shortest[:, 1] == 0).all()
    np.testing.assert_allclose(over, safe_set.peak(shortest)[0] - np.log(0.1))
    assert (safe_set.constraint(shortest) > 0)[over <= 0].any(), "it goes beyond what is allowed"


def test_the_wall_leaves_what_is_allowed_alone():
    model, U = learnt()
    safe_set = model.feasible(U)

    class Plane:
        def value(self, U):
            return U[:, 0] - 2.0 * U[:, 1]

        def gradient(self, U):
            return self.value(U), np.tile([1.0, -2.0], (len(U), 1))

    walled = Walled(Plane(), safe_set)
    at = np.random.default_rng(4).uniform(0, 1, (200, 2))
    allowed = safe_set.constraint(at) <= 0
    assert 0 < allowed.sum() < 200
    np.testing.assert_array_equal(walled.value(at)[allowed], Plane().value(at)[allowed])
    assert (walled.value(at)[~allowed] > Plane().value(at)[~allowed]).all()
    for got, plain in zip(walled.gradient(at), Plane().gradient(at), strict=True):
        np.testing.assert_array_equal(got[allowed], plain[allowed])


@dataclass(frozen=True, eq=False)
class Foretold(SafeSet):
    """Where the peaks of the shortest pushes are known beforehand."""

    pushes: np.ndarray = None
    over: np.ndarray = None

    def shortest(self, box):
        return self.pushes, self.over


class Helpful:
    def __init__(self, mean):
        self.mean = mean

    def predict(self, U):
        return self.mean, np.ones(len(self.mean))


@pytest.mark.parametrize(("noise", "made"), [(0.01, 0), (0.1, 1)])
def test_of_pushes_that_are_as_gentle_as_can_be_told_the_most_helpful_is_made(noise, made):
    shortest = np.array([[0.2, 0.0], [0.5, 0.0], [0.8, 0.0], [0.9, 0.0]])
    over, mean = np.array([0.30, 0.35, 0.60, 0.0]), np.array([-0.1, -0.2, -0.9, 0.1])
    known = Foretold(None, noise, None, 0.0, 1.6, 3.0, (0.0, 0.0), shortest, over)
    note = {"no_safe_push": 1.0}
    u, held = known.elsewhere(shortest[3], note, Helpful(mean), OUTER)
    assert (u.tolist(), held) == (shortest[made].tolist(), note)
