"""Draws from the posterior have its mean and spread, and the gradient they claim."""

import numpy as np
import pytest

from deformpush.gp import Constant
from deformpush.gp.regression import Posterior

from .cases import EVERY_FACTOR, THETA, samples


@pytest.mark.parametrize("kernel", EVERY_FACTOR, ids=str)
def test_draws_follow_the_posterior(kernel):
    X, y = samples(12, seed=2)
    theta = THETA.copy()
    theta[2] = kernel.theta()[2] if kernel.time == "tv" else theta[2]
    surface = Posterior.of(kernel, theta, Constant(), X, y, 2.0).at(12.0)
    U = np.random.default_rng(3).random((8, 2))
    rng = np.random.default_rng(4)
    draws = np.array([surface.draw(256, rng).value(U) for _ in range(600)])
    mu, sigma = surface.predict(U)
    # 600 draws: the mean is good to sigma / 24, the spread to about 3 %, five times that is allowed.
    assert (np.abs(draws.mean(axis=0) - mu) < 5 * sigma / np.sqrt(600)).all()
    np.testing.assert_allclose(draws.std(axis=0), sigma, rtol=0.16)


@pytest.mark.parametrize("kernel", EVERY_FACTOR, ids=str)
def test_gradient(kernel):
    X, y = samples(12, seed=5)
    surface = Posterior.of(kernel, THETA, Constant(), X, y, 2.0).at(12.0)
    path = surface.draw(64, np.random.default_rng(6))
    U = np.random.default_rng(7).random((5, 2))
    value, gradient = path.gradient(U)
    np.testing.assert_allclose(value, path.value(U), atol=1e-12)
    for axis, step in enumerate(1e-6 * np.eye(2)):
        numeric = (path.value(U + step) - path.value(U - step)) / 2e-6
        np.testing.assert_allclose(gradient[:, axis], numeric, rtol=1e-5, atol=1e-5)
