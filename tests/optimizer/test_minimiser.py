"""The minimisers find the bottom, stay inside, and say where they ended."""

import numpy as np
import pytest

from deformpush.gp import Matern52, Zero
from deformpush.gp.regression import Posterior
from deformpush.optimizer import BFGS, LCB, Adam, Thompson, TorchAdam
from deformpush.optimizer.acquisition import Context
from deformpush.optimizer.minimiser import polished

SQUARE = np.array([[0.0, 1.0], [0.0, 1.0]])
NO_SEEDS = np.empty((0, 2))
TICKS = np.linspace(0, 1, 200)
GRID = np.stack(np.meshgrid(TICKS, TICKS), axis=-1).reshape(-1, 2)


def random_context(seed, S):
    """A posterior with length scales from 0.1 to 1, in units where xi is standardised."""
    rng = np.random.default_rng(seed)
    kernel = Matern52(kappa=("open", "periodic")[seed % 2])
    theta = np.log([*np.exp(rng.uniform(np.log(0.1), 0.0, 2)), 20.0, 1.0, 0.1])
    tried = rng.random((S, 2))
    X = np.column_stack([tried, np.arange(S)])
    pairs = np.zeros((S, S))
    pairs[np.tril_indices(S, -1)] = kernel.gram(theta, kernel.distances(X))
    y = np.linalg.cholesky(pairs + pairs.T + 1.01 * np.eye(S)) @ rng.normal(size=S)
    return Context(Posterior.of(kernel, theta, Zero(), X, y, 1.0).at(S), tried, S, rng)


@pytest.mark.parametrize("minimiser", [Adam(), TorchAdam(), BFGS()], ids=lambda m: type(m).__name__)
@pytest.mark.parametrize("S", [10, 60, 200])
def test_no_grid_finds_a_lower_value(minimiser, S):
    for seed in range(4):
        objective = LCB(w=2.0).objective(random_context(seed, S))
        found = minimiser(objective, SQUARE, NO_SEEDS, np.random.default_rng(seed))
        values = objective.value(GRID)
        lowest = np.argmin(values)
        _, target, _ = polished(objective, SQUARE, GRID[lowest], values[lowest])
        assert found.value <= target + 1e-6
        assert found.value == pytest.approx(objective.value(found.u[None])[0], abs=1e-9)


class Plane:
    """Falls towards (1, 0)."""

    def value(self, U):
        return U[:, 1] - U[:, 0]

    def gradient(self, U):
        return self.value(U), np.tile([-1.0, 1.0], (len(U), 1))


class Bowl:
    """Lowest at (0.3, 0.7), scaled by `unit`."""

    def __init__(self, unit=1.0):
        self.unit = unit
        self.seen = 0

    def value(self, U):
        self.seen += len(U)
        return self.unit * (np.sum((U - (0.3, 0.7)) ** 2, axis=1) - 0.5)

    def gradient(self, U):
        return self.value(U), self.unit * 2 * (U - (0.3, 0.7))


MINIMISERS = [
    Adam(),
    TorchAdam(),
    BFGS(),
    Adam(screened=1, starts=1, steps=100, polish=False, incumbents=False),
]


@pytest.mark.parametrize("minimiser", MINIMISERS, ids=str)
def test_saturates_at_the_bounds_and_says_so(minimiser):
    box = np.array([[0.2, 0.5], [0.3, 0.9]])
    found = minimiser(Plane(), box, NO_SEEDS, np.random.default_rng(0))
    np.testing.assert_allclose(found.u, [0.5, 0.3], atol=1e-12)
    assert found.on_bound


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("minimiser", MINIMISERS[:3], ids=str)
def test_inside_at_any_scale_and_counting(minimiser, unit):
    bowl = Bowl(unit)
    found = minimiser(bowl, SQUARE, NO_SEEDS, np.random.default_rng(0))
    np.testing.assert_allclose(found.u, [0.3, 0.7], atol=1e-6)
    assert not found.on_bound
    assert found.evaluations == bowl.seen


def test_seeds_are_tried_inside_the_box():
    box = np.array([[0.0, 0.3], [0.0, 1.0]])
    greedy = Adam(screened=1, starts=1, steps=0, polish=False)
    seeds = np.array([[0.9, 0.7]])
    assert greedy(Bowl(), box, seeds, np.random.default_rng(0)).u.tolist() == [0.3, 0.7]


def test_thompson_has_the_same_minimiser():
    context = random_context(0, 20)
    objective = Thompson(256).objective(context)
    found = Adam()(objective, SQUARE, NO_SEEDS, np.random.default_rng(0))
    assert found.value <= objective.value(GRID[::7]).min() + 1e-9
