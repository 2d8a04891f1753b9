"""The error of the next state is that of eqs. (1) to (4), its spread over draws, its slopes those of both."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from deformpush.mechanics.geometry import rotation
from deformpush.model.error_of_motion import ErrorOfMotion, pose
from tests.states import GOAL, seen

STATE = seen(0.02, 0.07, 0.4)
AHEAD = np.array([[0.02, 0.0, 0.1, 0.0], [0.0, 0.03, -0.2, 0.01], [0.0, -0.02, 0.0, 0.0]])
rng = np.random.default_rng(0)
MEAN = rng.normal(0, (0.02, 0.02, 0.2, 0.01), (6, 4))
STD = rng.uniform(0.1, 1.0, (6, 4)) * (0.005, 0.005, 0.05, 0.005)


def e_T_after(state, y):
    x, y_, theta, shape = pose(state)
    c = (x, y_) + rotation(theta) @ y[:2]
    return GOAL(*c, theta + y[2], max(0.0, shape + y[3]))


def xi_of(state, y):
    return e_T_after(state, y) - GOAL(*pose(state))


def test_certain_outcomes_give_the_error_of_eqs_1_to_4():
    change = ErrorOfMotion(STATE, 64).change(MEAN, np.zeros_like(MEAN))
    np.testing.assert_allclose(change.mu, [xi_of(STATE, y) for y in MEAN], atol=1e-13)
    np.testing.assert_allclose(change.sigma, 0.0, atol=1e-7)


def test_angles_wrap():
    state = seen(0.0, 0.2, np.pi - 0.05)
    y = np.array([[0.0, 0.0, 0.1, 0.0]])  # across the far side of the circle
    change = ErrorOfMotion(state, 8).change(y, np.zeros_like(y))
    assert change.mu[0] == pytest.approx(0.0, abs=1e-12)


def test_moments_are_those_of_plain_monte_carlo():
    change = ErrorOfMotion(STATE, 256).change(MEAN, STD)
    z = np.random.default_rng(1).normal(size=(20000, 4))
    for i in range(len(MEAN)):
        xi = np.array([xi_of(STATE, y) for y in MEAN[i] + STD[i] * z[:4000]])
        assert change.mu[i] == pytest.approx(xi.mean(), abs=4 * xi.std() / 60)
        assert change.sigma[i] == pytest.approx(xi.std(), rel=0.08)


@pytest.mark.parametrize("ahead", [None, AHEAD])
def test_slopes_are_those_of_finite_differences(ahead):
    error = ErrorOfMotion(STATE, 32, ahead)
    change = error.gradient(MEAN, STD)
    for i in range(len(MEAN)):
        for x, by_mu, by_sigma, fill in (
            (MEAN[i], change.mu_by_mean[i], change.sigma_by_mean[i], lambda v, i=i: (v[None], STD[i][None])),
            (STD[i], change.mu_by_std[i], change.sigma_by_std[i], lambda v, i=i: (MEAN[i][None], v[None])),
        ):
            np.testing.assert_allclose(
                by_mu, approx_fprime(x, lambda v, f=fill: error.change(*f(v)).mu[0], 1e-8), atol=2e-5
            )
            np.testing.assert_allclose(
                by_sigma,
                approx_fprime(x, lambda v, f=fill: error.change(*f(v)).sigma[0], 1e-8),
                atol=2e-5,
            )


def test_draws_are_common_to_all_pushes_and_decisions():
    one, two = ErrorOfMotion(STATE, 16), ErrorOfMotion(seen(), 16)
    np.testing.assert_array_equal(one.z, two.z)
    single = [one.change(m[None], s[None]).sigma[0] for m, s in zip(MEAN, STD, strict=True)]
    np.testing.assert_allclose(one.change(MEAN, STD).sigma, single, atol=1e-14)


def test_two_ahead_counts_the_next_state_and_the_best_that_may_follow():
    error = ErrorOfMotion(STATE, 8, AHEAD)
    y = np.array([[0.01, 0.02, -0.1, 0.0]])

    def cost(first):
        x, y, theta, shape = pose(STATE)
        c = (x, y) + rotation(theta) @ first[:2]
        at = seen(*c, theta + first[2], max(0.0, shape + first[3]))
        now = e_T_after(STATE, first)
        return 0.5 * (now + min(now, *(e_T_after(at, second) for second in AHEAD)))

    change = error.change(y, np.zeros_like(y))
    assert change.mu[0] == pytest.approx(cost(y[0]) - cost(np.zeros(4)), abs=1e-12)


@pytest.mark.parametrize("ahead", [None, AHEAD])
def test_slopes_are_those_of_autograd(ahead):
    """Also where the shape error would fall below 0, and is 0."""
    torch = pytest.importorskip("torch")
    state = seen(0.02, 0.07, 0.4, shape=0.004)
    error = ErrorOfMotion(state, 32, ahead)
    mean, std = (torch.tensor(x, requires_grad=True) for x in (MEAN, STD))

    def moved(start, y):
        x, y_, theta, shape = start
        cos, sin = theta.cos(), theta.sin()
        there = x + cos * y[..., 0] - sin * y[..., 1], y_ + sin * y[..., 0] + cos * y[..., 1]
        return *there, theta + y[..., 2], (shape + y[..., 3]).clamp(min=0.0)

    def e_T(x, y, theta, shape):
        turn = torch.remainder(theta - GOAL.target.theta + np.pi, 2 * np.pi) - np.pi
        e_c = torch.hypot(x - GOAL.target.c[0], y - GOAL.target.c[1]) / GOAL.target.length
        return GOAL.weights.total(e_c, turn / np.pi, shape)

    after = moved([torch.tensor(p) for p in pose(state)], mean + std * torch.tensor(error.z)[:, None])
    xi = e_T(*after)
    if ahead is not None:
        best = e_T(*moved([p[..., None] for p in after], torch.tensor(ahead))).amin(dim=-1)
        xi = 0.5 * (xi + best.minimum(xi))
    xi = xi - error.stay
    mu, sigma = xi.mean(dim=0), xi.std(dim=0, unbiased=False)
    slopes = [torch.autograd.grad(m.sum(), (mean, std), retain_graph=True) for m in (mu, sigma)]
    change = error.gradient(MEAN, STD)
    wanted = (mu, sigma, *slopes[0], *slopes[1])
    for found, one in zip(change, wanted, strict=True):
        np.testing.assert_allclose(found, one.detach(), atol=1e-10)


def test_at_the_goal_itself_slopes_are_finite():
    state = seen(0.0, 0.2, 0.0, shape=0.0)
    change = ErrorOfMotion(state, 8).gradient(np.zeros((1, 4)), np.zeros((1, 4)))
    assert all(np.isfinite(x).all() for x in change)
    assert change.mu[0] == 0.0
