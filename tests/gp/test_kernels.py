"""Every kernel is positive definite, and its formula is the one it claims.

Also of `gp/kernel.py` and `gp/profiles.py`.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process.kernels import RBF, Matern

from deformpush.gp import Matern32, Matern52, Matern52Sum, SquaredExponential
from deformpush.gp.kernel import NAMES

from .cases import KERNELS, THETA, samples


def gram(kernel, theta, X):
    K = np.full((len(X), len(X)), np.nan)
    i, j = np.tril_indices(len(X), -1)
    K[i, j] = K[j, i] = kernel.gram(theta, kernel.distances(X))
    np.fill_diagonal(K, kernel.prior_variance(theta))
    return K


@pytest.mark.parametrize("kernel", KERNELS, ids=str)
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 10**6), rho=st.tuples(*[st.floats(-2.3, 0.7)] * 2), rho_t=st.floats(0.5, 5.0))
def test_positive_definite(kernel, seed, rho, rho_t):
    X, _ = samples(40, seed)
    theta = np.array([*rho, rho_t, 0.3, -2.0])
    eigenvalues = np.linalg.eigvalsh(gram(kernel, theta, X))
    assert eigenvalues[0] > -1e-12 * eigenvalues[-1]


ONE_D = {
    Matern52: Matern(1.0, nu=2.5),
    Matern32: Matern(1.0, nu=1.5),
    SquaredExponential: RBF(1.0),
    Matern52Sum: Matern(1.0, nu=2.5),
}


@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_formula_against_scikit_learn(kernel):
    X, _ = samples(30, seed=7)
    rho = np.exp(THETA[:3])
    one_d = ONE_D[type(kernel)]
    if kernel.kappa == "periodic":
        angle = 2 * np.pi * X[:, :1]
        circle = np.hstack([np.cos(angle), np.sin(angle)]) / (2 * np.pi)
    else:
        circle = X[:, :1]
    by_kappa, by_d = one_d(circle / rho[0]), one_d(X[:, 1:2] / rho[1])
    space = by_kappa + by_d if isinstance(kernel, Matern52Sum) else by_kappa * by_d
    dt = X[:, 2, None] - X[:, 2]
    time = {
        "matern52": lambda: Matern(rho[2], nu=2.5)(X[:, 2:]),
        "matern32": lambda: Matern(rho[2], nu=1.5)(X[:, 2:]),
        "ou": lambda: Matern(rho[2], nu=0.5)(X[:, 2:]),
        "tv": lambda: (1 - kernel.eps) ** (np.abs(dt) / 2),
        "window": lambda: 1.0,
        "none": lambda: 1.0,
    }[kernel.time]()
    theta = THETA.copy()
    if kernel.time == "tv":
        theta[2] = kernel.theta()[2]
    np.testing.assert_allclose(gram(kernel, theta, X), np.exp(2 * THETA[3]) * space * time, atol=1e-12)


def test_ou_is_tv_gp_ucb():
    """exp(-dt/tau) = (1 - eps)^(dt/2) at tau = -2 / ln(1 - eps)."""
    eps = 0.1
    tv, ou = Matern52(time="tv", eps=eps), Matern52(time="ou", rho_t=-2 / np.log(1 - eps))
    dt = np.linspace(0, 80, 33)
    np.testing.assert_allclose(tv.temporal(tv.theta(), dt), ou.temporal(ou.theta(), dt), atol=1e-14)
    np.testing.assert_allclose(tv.temporal(tv.theta(), dt), 0.9 ** (dt / 2), atol=1e-14)


def test_periodic_joins_the_ends():
    kernel = Matern52().resolved(closed=True)
    ends = np.array([[0.0, 0.5], [1.0, 0.5]])
    np.testing.assert_allclose(kernel.cross_covariance(THETA, ends)(ends), 1.0, atol=1e-12)
    assert Matern52().resolved(closed=False).cross_covariance(THETA, ends)(ends)[0, 1] < 0.1
    assert Matern52(kappa="open").resolved(closed=True).kappa == "open"


def test_window_forgets_altogether():
    kernel = Matern52(time="window", window=5)
    assert kernel.remembers(np.arange(10.0), now=10.0).tolist() == [False] * 5 + [True] * 5


def test_theta_names_the_fields():
    kernel = Matern52(rho_kappa=0.2, rho_d=0.4, rho_t=9.0, sigma_f=1.5, noise=0.07)
    np.testing.assert_allclose(np.exp(kernel.theta()), [getattr(kernel, name) for name in NAMES])
