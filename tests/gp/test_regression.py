"""Regression (9)-(11) and its likelihood against plain algebra and scikit-learn.

Also of `gp/cholesky.py`, `gp/cross_covariance.py` and `gp/means.py`.
"""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from deformpush.gp import Constant, Matern52, Zero
from deformpush.gp.cholesky import Cholesky
from deformpush.gp.regression import Posterior, log_likelihood
from deformpush.gp.regressor import scale_of

from .cases import KERNELS, THETA, samples


def dense(kernel, theta, A, B):
    """k(A, B), with the space part as every prediction takes it."""
    space = kernel.cross_covariance(theta, B[:, :2])(A[:, :2])
    return np.exp(2 * theta[3]) * space * kernel.temporal(theta, A[:, 2, None] - B[None, :, 2])


@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_posterior_is_eq_10_and_11(kernel):
    X, xi = samples(30, seed=1)
    posterior = Posterior.of(kernel, THETA, Zero(), X, xi, scale=2.0)
    U = np.random.default_rng(2).random((50, 2))
    star = np.column_stack([U, np.full(50, 31.0)])
    K = dense(kernel, THETA, X, X) + np.exp(2 * THETA[4]) * np.eye(30)
    k = dense(kernel, THETA, star, X)
    mu, sigma = posterior.at(31.0).predict(U)
    np.testing.assert_allclose(mu, k @ np.linalg.solve(K, xi), atol=1e-10)
    variance = np.diag(dense(kernel, THETA, star, star)) - np.einsum("ns,sn->n", k, np.linalg.solve(K, k.T))
    np.testing.assert_allclose(sigma, 2.0 * np.sqrt(variance), atol=1e-10)


@pytest.mark.parametrize("mean", [Zero(), Constant(0.7)])
@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_likelihood_gradient(kernel, mean):
    X, xi = samples(25, seed=3)
    distances = kernel.distances(X)
    value, gradient = log_likelihood(kernel, THETA, mean, distances, xi)
    numeric = approx_fprime(THETA, lambda x: log_likelihood(kernel, x, mean, distances, xi)[0], 1e-6)
    assert np.isfinite(value)
    learnable = kernel.learnable()
    np.testing.assert_allclose(gradient[learnable], numeric[learnable], rtol=2e-4, atol=2e-4)


@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_surface_gradient(kernel):
    X, xi = samples(25, seed=4)
    surface = Posterior.of(kernel, THETA, Constant(), X, xi, 1.3).at(25.5)
    U = np.random.default_rng(5).random((6, 2))
    mu, sigma, dmu, dsigma = surface.gradient(U)
    np.testing.assert_allclose(np.stack([mu, sigma]), np.stack(surface.predict(U)), atol=1e-13)
    for axis in range(2):
        step = np.zeros(2)
        step[axis] = 1e-6
        up, down = surface.predict(U + step), surface.predict(U - step)
        np.testing.assert_allclose(dmu[:, axis], (up[0] - down[0]) / 2e-6, rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(dsigma[:, axis], (up[1] - down[1]) / 2e-6, rtol=1e-5, atol=1e-7)


def test_learnt_constant_maximises_the_likelihood():
    X, xi = samples(20, seed=6)
    kernel, mean = Matern52(kappa="open"), Constant(2.0)
    level = Posterior.of(kernel, THETA, mean, X, xi, 1.0).level

    def at(m):
        return log_likelihood(kernel, THETA, Zero(), kernel.distances(X), xi - m)[0] - m**2 / 8

    assert at(level) > max(at(level - 1e-3), at(level + 1e-3))


def test_one_observation_in_closed_form():
    kernel = Matern52(kappa="open")
    X, noise = np.array([[0.4, 0.5, 0.0]]), np.exp(2 * THETA[4])
    surface = Posterior.of(kernel, THETA, Zero(), X, np.array([-3.0]), 1.0).at(0.0)
    mu, sigma = surface.predict(X[:, :2])
    s2 = np.exp(2 * THETA[3])
    assert mu[0] == pytest.approx(-3.0 * s2 / (s2 + noise))
    assert sigma[0] == pytest.approx(np.sqrt(s2 - s2**2 / (s2 + noise)))


@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_what_is_long_ago_is_forgotten_if_time_counts(kernel):
    """Far in the future the posterior is the prior again; a static kernel holds what it always did."""
    X, xi = samples(20, seed=4)
    posterior, U = Posterior.of(kernel, THETA, Zero(), X, xi, 1.0), X[:, :2]
    soon, late = posterior.at(20.0).predict(U), posterior.at(20.0 + 1e4).predict(U)
    if kernel.time in ("none", "window"):  # which pushes a window holds is settled before, by `remembers`
        np.testing.assert_array_equal(soon, late)
    else:
        assert np.abs(soon[0]).max() > 0.1
        np.testing.assert_allclose(late[0], 0.0, atol=1e-9)
        np.testing.assert_allclose(late[1], np.sqrt(kernel.prior_variance(THETA)), rtol=1e-9)


@pytest.mark.parametrize("kernel", KERNELS[::5], ids=str)
def test_without_noise_it_goes_through_the_data_and_leaves_them_alone(kernel):
    X, xi = samples(12, seed=5)
    given, silent = (X.copy(), xi.copy()), THETA.copy()
    silent[4] = np.log(1e-6)
    posterior = Posterior.of(kernel, silent, Zero(), X, xi, 1.0)
    if kernel.time not in ("none", "window"):
        X, xi = X[-1:], xi[-1:]  # the others were measured at another time
    mu, sigma = posterior.at(11.0).predict(X[:, :2])
    np.testing.assert_allclose(mu, xi, atol=1e-6)
    assert sigma.max() < 1e-4
    np.testing.assert_array_equal(given[0][-len(X) :], X)
    np.testing.assert_array_equal(given[1][-len(xi) :], xi)


def test_repeated_pushes_without_noise_need_reported_jitter():
    kernel = Matern52(kappa="open", time="none")
    X, xi = np.tile([[0.3, 0.3, 0.0]], (6, 1)), np.ones(6)
    silent = THETA.copy()
    silent[4] = np.log(1e-12)
    posterior = Posterior.of(kernel, silent, Zero(), X, xi, 1.0)
    assert posterior.jitter > 0
    assert posterior.at(0.0).predict(X[:1, :2])[0][0] == pytest.approx(1.0, abs=1e-3)


def test_a_covariance_that_is_not_finite_is_refused():
    with pytest.raises(np.linalg.LinAlgError, match="3 samples"):
        Cholesky(Matern52(kappa="open"), THETA, np.full(3, np.nan), 3)


@pytest.mark.parametrize("factor", [1e-170, 1e-6, 1.0, 1e6, 1e170])
def test_scale_is_the_root_mean_square(factor):
    assert scale_of(factor * np.array([3.0, -4.0])) == pytest.approx(factor * np.sqrt(12.5))
    assert scale_of(np.zeros(3)) == 1.0
