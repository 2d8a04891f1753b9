"""A process with a linear trend is a process whose covariance holds the trend's."""

import numpy as np
import pytest

from deformpush.gp.kernels import Matern52
from deformpush.gp.means import Zero
from deformpush.gp.regression import Posterior
from deformpush.gp.trend import TrendPosterior

SCALE = 0.3
SPREAD = np.array([0.9, 0.5])
KERNEL = Matern52().resolved(True)
THETA = np.log([0.1, 0.6, 20.0, 0.8, 0.3])


@pytest.fixture
def samples():
    rng = np.random.default_rng(0)
    X = np.column_stack([rng.uniform(0, 1, (9, 2)), np.arange(9.0)])
    H = np.column_stack([np.ones(9), rng.uniform(0, 2, 9)])
    return X, H, H @ [0.5, -0.4] + 0.1 * rng.standard_normal(9)


def trended(samples) -> TrendPosterior:
    X, H, y = samples
    return TrendPosterior(Posterior.of(KERNEL, THETA, Zero(), X, y, SCALE), 9.0, H, y, SPREAD)


def covariance(A, B) -> np.ndarray:
    """Of f between pushes A and B `(., 3)`, in units of y."""
    both = np.concatenate([A, B])
    pairs = KERNEL.gram(THETA, KERNEL.distances(both))
    K = np.zeros((len(both), len(both)))
    K[np.tril_indices(len(both), -1)] = pairs
    K += K.T + KERNEL.prior_variance(THETA) * np.eye(len(both))
    return SCALE**2 * K[: len(A), len(A) :]


def test_it_is_the_process_with_the_trend_in_its_covariance(samples):
    X, H, y = samples
    rng = np.random.default_rng(1)
    U, h = rng.uniform(0, 1, (6, 2)), np.column_stack([np.ones(6), rng.uniform(0, 3, 6)])
    new = np.column_stack([U, np.full(6, 9.0)])
    noise = (SCALE * np.exp(THETA[4])) ** 2
    K = covariance(X, X) + noise * np.eye(9) + H @ np.diag(SPREAD**2) @ H.T
    k = covariance(new, X) + h @ np.diag(SPREAD**2) @ H.T
    prior = np.diag(covariance(new, new)) + np.einsum("ni,i,ni->n", h, SPREAD**2, h)
    mu, sigma = trended(samples).predict(U, h)
    np.testing.assert_allclose(mu, k @ np.linalg.solve(K, y), rtol=1e-9)
    np.testing.assert_allclose(
        sigma**2, prior - np.einsum("ns,ns->n", k, np.linalg.solve(K, k.T).T), rtol=1e-8
    )


def test_gradients_are_those_of_the_prediction(samples):
    known = trended(samples)
    U, h = np.random.default_rng(2).uniform(0.05, 0.95, (8, 2)), np.tile([1.0, 0.7], (8, 1))
    mu, sigma, dmu, dsigma = known.gradient(U, h)
    np.testing.assert_allclose(np.stack([mu, sigma]), known.predict(U, h))
    for j in range(2):
        step = np.eye(2)[j] * 1e-6
        up, down = known.predict(U + step, h), known.predict(U - step, h)
        np.testing.assert_allclose(dmu[:, j], (up[0] - down[0]) / 2e-6, rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(dsigma[:, j], (up[1] - down[1]) / 2e-6, rtol=1e-5, atol=1e-7)


def test_what_the_data_do_not_tell_of_the_trend_widens_the_prediction(samples):
    known = trended(samples)
    at = np.array([[0.5, 0.5]])
    near, far = (known.predict(at, np.array([[1.0, feature]]))[1][0] for feature in (1.0, 6.0))
    assert far > 2.0 * near
