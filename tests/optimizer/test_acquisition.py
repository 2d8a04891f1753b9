"""Every acquisition is its formula, and BoTorch's where BoTorch has it.

Also of `optimizer/objective.py`.
"""

import numpy as np
import pytest
from scipy import stats

from deformpush.gp import Matern52, Zero
from deformpush.gp.regression import Posterior
from deformpush.optimizer import EI, LCB, PI, LCBSchedule, Thompson
from deformpush.optimizer.acquisition import Context, lower_confidence, negative_log_ei, negative_log_pi


def context(t=20, seed=0):
    rng = np.random.default_rng(seed)
    kernel = Matern52(kappa="open")
    tried = rng.random((t, 2))
    X = np.column_stack([tried, np.arange(t)])
    xi = 0.1 * (np.sin(6 * tried[:, 0]) - tried[:, 1]) + 0.01 * rng.normal(size=t)
    posterior = Posterior.of(kernel, kernel.theta(), Zero(), X, xi, 0.1)
    return Context(posterior.at(t), tried, t, np.random.default_rng(seed))


U = np.random.default_rng(9).random((40, 2))
MU, SIGMA = (x.ravel() for x in np.meshgrid(np.linspace(-2, 2, 9), np.geomspace(1e-3, 2, 7)))


def test_lcb():
    now = context()
    mu, sigma = now.surface.predict(U)
    np.testing.assert_allclose(LCB(w=1.7).objective(now).value(U), mu - 1.7 * sigma, rtol=1e-12)
    np.testing.assert_array_equal(LCB(w=0.0).objective(now).value(U), mu)


@pytest.mark.parametrize("t", [1, 10, 80])
def test_lcb_schedule(t):
    now = context(t)
    mu, sigma = now.surface.predict(U)
    w = np.sqrt(0.8 * np.log(4.0 * t))
    np.testing.assert_allclose(
        LCBSchedule(c1=0.8, c2=4.0).objective(now).value(U), mu - w * sigma, rtol=1e-12
    )


def test_lcb_schedule_never_turns_negative():
    assert np.isfinite(LCBSchedule(c2=0.01).objective(context(2)).value(U)).all()


def test_ei_and_pi_count_from_the_best_mean_of_now():
    now = context()
    mu, sigma = now.surface.predict(U)
    best = now.surface.predict(now.tried)[0].min()
    z = (best - 0.02 - mu) / sigma
    expected = sigma * (stats.norm.pdf(z) + z * stats.norm.cdf(z))
    likely = expected > 1e-12
    np.testing.assert_allclose(
        np.exp(-EI(margin=0.02).objective(now).value(U))[likely], expected[likely], rtol=1e-6
    )
    np.testing.assert_allclose(np.exp(-PI(margin=0.02).objective(now).value(U)), stats.norm.cdf(z), rtol=1e-9)


def test_ei_is_the_expectation_it_claims():
    draws = np.random.default_rng(1).normal(0.1, 0.3, 400_000)
    improvement = np.maximum(-0.05 - draws, 0)
    value = np.exp(-negative_log_ei(np.array([0.1]), np.array([0.3]), -0.05).a[0])
    assert value == pytest.approx(improvement.mean(), abs=5 * improvement.std() / np.sqrt(len(draws)))


@pytest.mark.filterwarnings("ignore")
def test_against_botorch():
    pytest.importorskip("botorch", reason="extra `rivals` is not installed")
    import torch
    from botorch.acquisition import analytic
    from botorch.utils.testing import MockModel, MockPosterior

    model = MockModel(
        MockPosterior(mean=torch.tensor(MU)[:, None, None], variance=torch.tensor(SIGMA**2)[:, None, None])
    )
    X = torch.zeros(len(MU), 1, 2)
    best = -0.25  # BoTorch keeps it in single precision
    log_ei = analytic.LogExpectedImprovement(model, best_f=best, maximize=False)(X)
    np.testing.assert_allclose(negative_log_ei(MU, SIGMA, best).a, -log_ei, rtol=1e-9)
    log_pi = analytic.LogProbabilityOfImprovement(model, best_f=best, maximize=False)(X)
    np.testing.assert_allclose(negative_log_pi(MU, SIGMA, best).a, -log_pi, rtol=1e-9, atol=1e-15)
    bound = analytic.UpperConfidenceBound(model, beta=4.0, maximize=False)(X)
    np.testing.assert_allclose(lower_confidence(MU, SIGMA, 2.0).a, -bound, rtol=1e-12)


@pytest.mark.parametrize("a", [negative_log_ei, negative_log_pi, lower_confidence])
def test_partial_derivatives(a):
    mu, sigma = MU[SIGMA > 0.01], SIGMA[SIGMA > 0.01]
    h = 1e-6
    _, by_mu, by_sigma = a(mu, sigma, -0.3)
    np.testing.assert_allclose(
        by_mu, (a(mu + h, sigma, -0.3).a - a(mu - h, sigma, -0.3).a) / 2 / h, rtol=1e-4, atol=1e-6
    )
    np.testing.assert_allclose(
        by_sigma, (a(mu, sigma + h, -0.3).a - a(mu, sigma - h, -0.3).a) / 2 / h, rtol=1e-4, atol=1e-6
    )


@pytest.mark.parametrize("a", [negative_log_ei, negative_log_pi])
def test_finite_where_improvement_is_out_of_reach(a):
    mu = np.r_[0.0, np.geomspace(1e-3, 1e9, 60), -np.geomspace(1e-3, 1e9, 60)]
    value, by_mu, by_sigma = a(mu, np.full_like(mu, 1e-3), 0.0)
    assert np.isfinite(value).all()
    assert np.isfinite(by_mu).all()
    assert np.isfinite(by_sigma).all()
    assert (np.diff(value[1:61]) > 0).all(), "further away is less likely"


@pytest.mark.parametrize("acquisition", [LCB(), LCBSchedule(), EI(), PI(), Thompson(64)], ids=str)
def test_gradient(acquisition):
    objective = acquisition.objective(context())
    value, gradient = objective.gradient(U)
    np.testing.assert_allclose(value, objective.value(U), rtol=1e-9, atol=1e-12)
    for axis, step in enumerate(1e-6 * np.eye(2)):
        numeric = (objective.value(U + step) - objective.value(U - step)) / 2e-6
        np.testing.assert_allclose(gradient[:, axis], numeric, rtol=1e-4, atol=1e-5)


def test_thompson_draws_differ_between_pushes_and_not_within_one():
    first, again, other = (Thompson().objective(context(seed=s)).value(U) for s in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    assert not np.allclose(first, other)
