"""Hyper-parameters: the search finds the top and survives any data.

Also of `gp/bfgs.py` and `gp/regressor.py`.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.gp import MAP, Constant, Fixed, Matern52, Regressor, Zero, bfgs
from deformpush.gp.regression import log_likelihood
from deformpush.gp.regressor import scale_of

from .cases import KERNELS, samples


def density(fit, kernel, mean, X, y, theta):
    z = [np.log(t / m) / np.log(f) for t, (m, f) in zip(np.exp(theta), priors(fit), strict=True)]
    value = log_likelihood(kernel, theta, mean, kernel.distances(X), y)[0]
    return value - 0.5 * sum(v**2 for v, learnt in zip(z, kernel.learnable(), strict=True) if learnt)


def priors(fit):
    return [fit.rho_kappa, fit.rho_d, fit.rho_t, fit.sigma_f, fit.noise]


@pytest.mark.parametrize("kernel", KERNELS[::3], ids=str)
@pytest.mark.parametrize("S", [10, 40])
def test_map_is_a_maximum(kernel, S):
    X, y = samples(S, seed=S)
    fit, mean = MAP(), Zero()
    theta = fit(kernel, mean, X, y, kernel.theta()).theta
    top = density(fit, kernel, mean, X, y, theta)
    assert top >= density(fit, kernel, mean, X, y, kernel.theta())
    for i in np.flatnonzero(kernel.learnable()):
        for step in (-0.05, 0.05):
            moved = theta.copy()
            moved[i] += step
            assert density(fit, kernel, mean, X, y, moved) < top + 1e-6
    np.testing.assert_array_equal(theta[~kernel.learnable()], kernel.theta()[~kernel.learnable()])


def test_map_finds_the_length_scales_it_was_given():
    rng = np.random.default_rng(0)
    kernel = Matern52(rho_kappa=0.15, rho_d=0.8, rho_t=30.0, noise=0.05, kappa="open")
    X = np.column_stack([rng.random((150, 2)), np.arange(150.0)])
    i, j = np.tril_indices(150, -1)
    K = np.eye(150) * (1 + 0.05**2)
    K[i, j] = K[j, i] = kernel.gram(kernel.theta(), kernel.distances(X))
    y = np.linalg.cholesky(K) @ rng.normal(size=150)
    found = MAP()(Matern52(kappa="open"), Zero(), X, y, Matern52().theta()).theta
    np.testing.assert_allclose(found, kernel.theta(), atol=np.log(1.6))


def test_fixed_is_the_configuration():
    kernel = Matern52(rho_t=7.0)
    X, y = samples(5, seed=0)
    np.testing.assert_array_equal(Fixed()(kernel, Zero(), X, y, np.zeros(5)).theta, kernel.theta())


AWKWARD = {
    "one sample": (np.array([[0.5, 0.5, 0.0]]), np.array([-0.3])),
    "constant": (samples(12, 0)[0], np.full(12, -0.2)),
    "zero": (samples(12, 0)[0], np.zeros(12)),
    "same push": (np.column_stack([np.full((12, 2), 0.3), np.arange(12)]), np.sin(np.arange(12))),
    "same push and time": (np.full((12, 3), 0.3), np.sin(np.arange(12))),
    "outlier": (samples(12, 0)[0], np.r_[np.full(11, 1e-9), 1.0]),
}


@pytest.mark.parametrize("mean", [Zero(), Constant()])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("case", AWKWARD)
def test_awkward_data_never_raise(case, scale, mean):
    X, xi = AWKWARD[case]
    kernel = Matern52(kappa="periodic")
    posterior, info = Regressor(kernel, mean, MAP(), 200).condition(X, xi * scale, 0.0, X[-1, 2] + 1)
    mu, sigma = posterior.at(X[-1, 2] + 1).predict(np.random.default_rng(0).random((20, 2)))
    assert np.isfinite(mu).all()
    assert (sigma > 0).all()
    assert np.isfinite(list(info.values())).all()
    assert info["fit_kept"] == 0


def test_last_good_values_are_kept_when_nothing_is_finite():
    X, _ = samples(4, 0)
    last = np.log([0.1, 0.2, 3.0, 1.0, 0.1])
    fitted = MAP()(Matern52(kappa="open"), Zero(), X, np.full(4, np.nan), last)
    assert fitted.kept
    np.testing.assert_array_equal(fitted.theta, last)


@settings(max_examples=20, deadline=None)
@given(order=st.permutations(range(15)), shift=st.floats(-50, 50))
def test_order_of_data_and_origin_of_time_do_not_matter(order, shift):
    X, y = samples(15, seed=9)
    kernel, fit = Matern52(kappa="open"), MAP()
    moved = X[list(order)] + (0, 0, shift)
    first = fit(kernel, Zero(), X, y, kernel.theta()).theta
    second = fit(kernel, Zero(), moved, y[list(order)], kernel.theta()).theta
    np.testing.assert_allclose(first, second, atol=1e-4)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_projected_bfgs_solves_quadratics_in_a_box(seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(4, 4))
    A, b = A @ A.T + 0.1 * np.eye(4), rng.normal(size=4)
    lo, hi = np.full(4, -0.5), np.full(4, 0.5)
    x, value, _ = bfgs.minimise(
        lambda x: (0.5 * x @ A @ x - b @ x, A @ x - b), rng.uniform(lo, hi), lo, hi, 200
    )
    gradient = A @ x - b
    assert value == pytest.approx(0.5 * x @ A @ x - b @ x)
    inside = (x > lo) & (x < hi)
    assert np.abs(gradient[inside]).max(initial=0) < 1e-5
    assert (gradient[x == lo] >= 0).all()
    assert (gradient[x == hi] <= 0).all()


def test_a_thousand_samples_are_fitted_by_the_newest_and_predicted_by_all():
    X, xi = samples(1000, seed=4)
    kernel = Matern52(kappa="open")
    posterior, info = Regressor(kernel, Zero(), MAP(), 30, 1000).condition(X, xi, 0.0, 1000.0)
    newest = MAP()(kernel, Zero(), X[-30:], xi[-30:] / scale_of(xi), kernel.theta()).theta
    np.testing.assert_array_equal(posterior.theta, newest)
    assert info["samples"] == len(posterior.X) == 1000


def test_predictions_are_made_from_the_newest_samples_at_their_own_times():
    X, xi = samples(400, seed=6)
    kernel = Matern52(kappa="open")
    usual, told = Regressor(kernel, Zero(), Fixed()), Regressor(kernel, Zero(), Fixed(), 200, 400)
    some, info = usual.condition(X, xi, 1.0, 400.0)
    every, _ = told.condition(X, xi, 1.0, 400.0)
    assert info["samples"] == 300
    assert usual.fitted == told.fitted == 400
    np.testing.assert_array_equal(some.X, X[-300:])
    few, _ = usual.condition(X[:300], xi[:300], 1.0, 300.0)
    np.testing.assert_array_equal(few.X, X[:300])
    U = np.random.default_rng(0).uniform(0, 1, (50, 2))
    for a, b in zip(some.at(400.0).predict(U), every.at(400.0).predict(U), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_a_window_predicts_from_the_newest_alone():
    X, xi = samples(40, seed=5)
    kernel = Matern52(kappa="open", time="window", window=10)
    posterior, info = Regressor(kernel, Zero(), Fixed(), 200).condition(X, xi, 0.0, 40.0)
    assert info["samples"] == 10
    np.testing.assert_array_equal(posterior.X, X[-10:])
