"""A kernel of one's own, one more number to learn included, is its formula and nothing else.

Also of `gp/cross_covariance.py` and `gp/sample_path.py`, as far as they serve formulas.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process import kernels as sk

from deformpush.gp import MAP, Constant, Correlation, FormulaKernel, Matern52, Regressor, Zero
from deformpush.gp.correlation import slope
from deformpush.gp.regression import Posterior, log_likelihood
from tests.own_kernel import RationalQuadratic

from .cases import samples


@dataclass(frozen=True)
class Isotropic(RationalQuadratic):
    """Of the distance in the plane, no product over its coordinates."""

    def plane(self, r):
        return self(np.hypot(*r))


@dataclass(frozen=True)
class Matern(Correlation):
    """The built-in one once more, by its formula."""

    def __call__(self, r):
        a = np.sqrt(5.0) * r
        return (1.0 + a + a**2 / 3.0) * np.exp(-a)


THETA = np.log([0.35, 0.6, 12.0, 0.9, 0.1, 0.7])
KERNELS = [
    FormulaKernel(space=RationalQuadratic(), kappa="open"),
    FormulaKernel(space=RationalQuadratic(), kappa="periodic", time="none"),
    FormulaKernel(space=Isotropic(), kappa="open", time="ou"),
    Matern52(time=RationalQuadratic(), kappa="periodic"),
    FormulaKernel(space=RationalQuadratic(), time=RationalQuadratic(), kappa="open"),
]
ids = ["space", "circle", "plane", "time", "both"]


def theta_of(kernel):
    return np.append(THETA, np.log(1.8)) if len(kernel.theta()) == 7 else THETA


def square(kernel, theta, X):
    K = kernel.prior_variance(theta) * np.eye(len(X))
    i, j = np.tril_indices(len(X), -1)
    K[i, j] = K[j, i] = kernel.gram(theta, kernel.distances(X))
    return K


def test_what_it_learns_is_named_after_where_it_stands():
    kernel = FormulaKernel(space=RationalQuadratic(0.5), time=RationalQuadratic(3.0), rho_t=9.0)
    assert kernel.names[5:] == ("space_alpha", "time_alpha")
    np.testing.assert_allclose(np.exp(kernel.theta()[[2, 5, 6]]), (9.0, 0.5, 3.0))
    assert kernel.learnable().all()
    assert Matern52(time=RationalQuadratic()).names[5:] == ("time_alpha",)
    assert len(Matern52(time=Matern()).names) == 5


def test_over_kappa_and_d_it_is_scikit_learns():
    X, _ = samples(30, seed=7)
    scaled, dt = X[:, :2] / np.exp(THETA[:2]), X[:, 2:]
    one_d, time = sk.RationalQuadratic(1.0, alpha=0.7), sk.Matern(np.exp(THETA[2]), nu=2.5)(dt)
    for space, expected in (
        (RationalQuadratic(), one_d(scaled[:, :1]) * one_d(scaled[:, 1:])),
        (Isotropic(), one_d(scaled)),
    ):
        K = square(FormulaKernel(space=space, kappa="open"), THETA, X)
        np.testing.assert_allclose(K, np.exp(2 * THETA[3]) * expected * time, atol=1e-13)


def test_over_time_it_is_scikit_learns():
    X, _ = samples(30, seed=7)
    built_in, mine = Matern52(time="none", kappa="open"), Matern52(time=RationalQuadratic(), kappa="open")
    time = sk.RationalQuadratic(np.exp(THETA[2]), alpha=0.7)(X[:, 2:])
    np.testing.assert_allclose(square(mine, THETA, X), square(built_in, THETA[:5], X) * time, atol=1e-13)


def test_the_regression_is_scikit_learns():
    """Posterior, likelihood, and its slope by length scale and alpha."""
    X, y = samples(40, seed=3)
    kernel = FormulaKernel(space=Isotropic(), time="none", kappa="open")
    theta = np.log([0.5, 0.5, 1.0, 0.9, 0.1, 0.7])
    oracle = GaussianProcessRegressor(
        sk.ConstantKernel(0.9**2) * sk.RationalQuadratic(0.5, alpha=0.7), alpha=0.1**2, optimizer=None
    ).fit(X[:, :2], y)
    U = np.random.default_rng(0).random((20, 2))
    expected_mu, expected_sigma = oracle.predict(U, return_std=True)
    mu, sigma = Posterior.of(kernel, theta, Zero(), X, y, 1.0).at(40.0).predict(U)
    np.testing.assert_allclose(mu, expected_mu, atol=1e-10)
    np.testing.assert_allclose(sigma, expected_sigma, atol=1e-10)
    value, gradient = log_likelihood(kernel, theta, Zero(), kernel.distances(X), y)
    expected, (_, by_alpha, by_rho) = oracle.log_marginal_likelihood(oracle.kernel_.theta, eval_gradient=True)
    assert value == pytest.approx(expected, abs=1e-9)
    np.testing.assert_allclose((gradient[5], gradient[0] + gradient[1]), (by_alpha, by_rho), rtol=1e-7)


@pytest.mark.parametrize("kappa", ["open", "periodic"])
def test_the_general_path_agrees_with_derivatives_by_hand(kappa):
    """Matern 5/2 by its formula in space and time, beside the built-in one."""
    X, y = samples(25, seed=3)
    by_hand, by_formula = Matern52(kappa=kappa), FormulaKernel(space=Matern(), time=Matern(), kappa=kappa)
    theta, distances = THETA[:5], by_hand.distances(X)
    for one, other in zip(
        log_likelihood(by_hand, theta, Constant(), distances, y),
        log_likelihood(by_formula, theta, Constant(), by_formula.distances(X), y),
        strict=True,
    ):
        np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9)
    U = np.vstack([np.random.default_rng(1).random((10, 2)), X[:3, :2], X[:3, :2] + 1e-9])
    slices = [Posterior.of(k, theta, Zero(), X, y, 1.3).at(26.0) for k in (by_hand, by_formula)]
    for one, other in zip(*(s.gradient(U) for s in slices), strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-7, atol=1e-8)
    fitted = [MAP()(k, Zero(), X, y, k.theta()).theta for k in (by_hand, by_formula)]
    np.testing.assert_allclose(*fitted, atol=1e-4)


@pytest.mark.parametrize("kernel", KERNELS, ids=ids)
def test_derivatives(kernel):
    X, y = samples(20, seed=4)
    theta, distances = theta_of(kernel), kernel.distances(X)
    _, gradient = log_likelihood(kernel, theta, Constant(), distances, y)
    numeric = approx_fprime(theta, lambda x: log_likelihood(kernel, x, Constant(), distances, y)[0], 1e-6)
    np.testing.assert_allclose(gradient, numeric, rtol=2e-4, atol=2e-4)
    now = Posterior.of(kernel, theta, Constant(), X, y, 1.3).at(20.0)
    path, U = now.draw(144, np.random.default_rng(0)), np.random.default_rng(5).random((6, 2))
    mu, sigma, dmu, dsigma = now.gradient(U)
    np.testing.assert_allclose((mu, sigma), now.predict(U), atol=1e-13)
    value, drawn = path.gradient(U)
    np.testing.assert_allclose(value, path.value(U), rtol=1e-9)
    for j, step in enumerate(np.eye(2) * 1e-6):
        up, down = now.predict(U + step), now.predict(U - step)
        for got, rise in (
            (dmu, up[0] - down[0]),
            (dsigma, up[1] - down[1]),
            (drawn, path.value(U + step) - path.value(U - step)),
        ):
            np.testing.assert_allclose(got[:, j], rise / 2e-6, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("kernel", KERNELS, ids=ids)
def test_the_fit_learns_its_number_too(kernel):
    X, y = samples(30, seed=6)
    fit, distances = MAP(), kernel.distances(X)
    priors = np.log([fit.rho_kappa, fit.rho_d, fit.rho_t, fit.sigma_f, fit.noise, *kernel.further_priors])
    learn = kernel.learnable()

    def density(theta):
        z = ((theta - priors[:, 0]) / priors[:, 1])[learn]
        return log_likelihood(kernel, theta, Zero(), distances, y)[0] - 0.5 * z @ z

    theta = fit(kernel, Zero(), X, y, kernel.theta()).theta
    assert (theta[5:] != kernel.theta()[5:]).all()
    for step in np.eye(len(theta))[learn] * 0.05:
        assert max(density(theta + step), density(theta - step)) < density(theta) + 1e-6


def test_alpha_is_found_again():
    """Between a rough function of many scales and a smooth one of a single scale."""
    rng = np.random.default_rng(0)
    X = np.column_stack([rng.random((120, 2)), np.zeros(120)])
    kernel, found = FormulaKernel(space=RationalQuadratic(), time="none", kappa="open"), []
    for alpha in (0.15, 20.0):
        theta = np.log([0.2, 0.3, 20.0, 1.0, 0.02, alpha])
        y = np.linalg.cholesky(square(kernel, theta, X) + 0.02**2 * np.eye(120)) @ rng.normal(size=120)
        found.append(np.exp(MAP()(kernel, Zero(), X, y, kernel.theta()).theta[5]))
    assert found[0] < 0.5
    assert found[1] > 2.0


def test_it_is_kept_warm_named_and_restored():
    X, y = samples(12, seed=1)
    kernel = FormulaKernel(space=RationalQuadratic(), kappa="open")
    one, other = (Regressor(kernel, Zero(), MAP(), 200) for _ in range(2))
    assert np.isnan(one.state()[0]).all()
    assert len(one.state()[0]) == 6
    _, info = one.condition(X[:10], y[:10], 0.0, 10.0)
    assert info["space_alpha"] == np.exp(one.theta[5])
    other.restore(*one.state())
    for regressor in (one, other):
        regressor.condition(X, y, 0.0, 12.0)
    np.testing.assert_array_equal(one.theta, other.theta)


@pytest.mark.parametrize("kernel", KERNELS, ids=ids)
def test_draws_follow_the_posterior(kernel):
    X, y = samples(12, seed=2)
    now = Posterior.of(kernel, theta_of(kernel), Constant(), X, y, 2.0).at(12.0)
    U, rng = np.random.default_rng(3).random((8, 2)), np.random.default_rng(4)
    draws = np.array([now.draw(144, rng).value(U) for _ in range(600)])
    mu, sigma = now.predict(U)
    assert (np.abs(draws.mean(axis=0) - mu) < 5 * sigma / np.sqrt(600)).all()
    np.testing.assert_allclose(draws.std(axis=0), sigma, rtol=0.16)


@pytest.mark.parametrize("f", [np.exp, np.sin, lambda x: 1.0 / (2.0 + x)])
def test_slope(f):
    x = np.linspace(0, 2, 9)
    exact = {np.exp: np.exp, np.sin: np.cos}.get(f, lambda x: -1.0 / (2.0 + x) ** 2)(x)
    np.testing.assert_allclose(slope(f, x, np.ones(9)), exact, atol=3e-12)


@dataclass(frozen=True)
class Doubled(Matern):
    def __call__(self, r):
        return 2.0 * super().__call__(r)


@dataclass(frozen=True)
class Unfinished(Correlation):
    pass


def test_what_is_wrong_with_a_formula_is_said():
    with pytest.raises(ValueError, match=r"^space: Doubled is 4 at distance 0, must be 1"):
        FormulaKernel(space=Doubled())
    with pytest.raises(ValueError, match=r"^time: Doubled is 2 at distance 0, must be 1"):
        Matern52(time=Doubled())
    with pytest.raises(ValueError, match=r"^time: Unfinished must define __call__\(self, r\)"):
        Matern52(time=Unfinished())
