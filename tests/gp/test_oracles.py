"""The regression against scikit-learn, GPyTorch and autograd, for every kernel, up to 200 samples."""

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Matern

from deformpush.gp import Matern32, Matern52, Matern52Sum, SquaredExponential, Zero
from deformpush.gp.regression import Posterior, log_likelihood

from .cases import KERNELS, THETA, samples

NU = {Matern52: 2.5, Matern32: 1.5, SquaredExponential: np.inf, Matern52Sum: 2.5}
TIME_NU = {"matern52": 2.5, "matern32": 1.5, "ou": 0.5, "tv": 0.5}


def theta_of(kernel):
    theta = THETA.copy()
    if kernel.time == "tv":
        theta[2] = kernel.theta()[2]
    return theta


def embedded(kernel, X):
    """Columns x, y, d, t: the circle of a periodic kappa, or kappa and nothing."""
    if kernel.kappa == "periodic":
        angle = 2 * np.pi * X[:, 0]
        plane = np.column_stack([np.cos(angle), np.sin(angle)]) / (2 * np.pi)
    else:
        plane = np.column_stack([X[:, 0], np.zeros(len(X))])
    return np.column_stack([plane, X[:, 1:]])


def sklearn_kernel(kernel, theta):
    far = 1e12
    rho = np.exp(theta[:3])

    def one(scales, nu):
        return RBF(scales) if np.isinf(nu) else Matern(scales, nu=nu)

    by_kappa = one([rho[0], rho[0], far, far], NU[type(kernel)])
    by_d = one([far, far, rho[1], far], NU[type(kernel)])
    space = by_kappa + by_d if isinstance(kernel, Matern52Sum) else by_kappa * by_d
    if kernel.time in TIME_NU:
        space = space * one([far, far, far, rho[2]], TIME_NU[kernel.time])
    return ConstantKernel(np.exp(2 * theta[3])) * space


def ours(kernel, theta, X, y, star):
    posterior = Posterior.of(kernel, theta, Zero(), X, y, 1.0)
    mu, sigma = np.array([[x[0] for x in posterior.at(t).predict(np.array([u]))] for *u, t in star]).T
    return mu, sigma, log_likelihood(kernel, theta, Zero(), kernel.distances(X), y)[0]


def points(n, S):
    rng = np.random.default_rng(8)
    # Between pushes: GPyTorch's distances lose half their digits where the exponential kernel has its cusp.
    return np.column_stack([rng.random((n, 2)), rng.integers(0, S + 5, n) + 0.5])


@pytest.mark.parametrize("S", [10, 200])
@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_against_scikit_learn(kernel, S):
    theta, (X, y), star = theta_of(kernel), samples(S, seed=S), points(20, S)
    oracle = GaussianProcessRegressor(
        sklearn_kernel(kernel, theta), alpha=np.exp(2 * theta[4]), optimizer=None
    )
    oracle.fit(embedded(kernel, X), y)
    mu, sigma, likelihood = ours(kernel, theta, X, y, star)
    expected_mu, expected_sigma = oracle.predict(embedded(kernel, star), return_std=True)
    np.testing.assert_allclose(mu, expected_mu, atol=1e-10, rtol=0)
    np.testing.assert_allclose(sigma, expected_sigma, atol=1e-10, rtol=0)
    assert likelihood == pytest.approx(oracle.log_marginal_likelihood_value_, abs=1e-9)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_against_gpytorch(kernel):
    gpytorch = pytest.importorskip("gpytorch", reason="extra `rivals` is not installed")
    import torch

    S = 200
    theta, (X, y), star = theta_of(kernel), samples(S, seed=S), points(20, S)
    rho = np.exp(theta[:3])

    def one(scale, nu, dims):
        kind = gpytorch.kernels.RBFKernel if np.isinf(nu) else gpytorch.kernels.MaternKernel
        made = kind(active_dims=dims, **({} if np.isinf(nu) else {"nu": nu})).double()
        made.lengthscale = scale
        return made

    by_kappa, by_d = one(rho[0], NU[type(kernel)], (0, 1)), one(rho[1], NU[type(kernel)], (2,))
    covariance = by_kappa + by_d if isinstance(kernel, Matern52Sum) else by_kappa * by_d
    if kernel.time in TIME_NU:
        covariance = covariance * one(rho[2], TIME_NU[kernel.time], (3,))
    covariance = gpytorch.kernels.ScaleKernel(covariance).double()
    covariance.outputscale = np.exp(2 * theta[3])

    class Model(gpytorch.models.ExactGP):
        def __init__(self, inputs, targets, likelihood):
            super().__init__(inputs, targets, likelihood)
            self.mean_module, self.covar_module = gpytorch.means.ZeroMean(), covariance

        def forward(self, x):
            return gpytorch.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))

    likelihood = gpytorch.likelihoods.GaussianLikelihood().double()
    likelihood.noise = np.exp(2 * theta[4])
    inputs, targets = torch.tensor(embedded(kernel, X)), torch.tensor(y)
    model = Model(inputs, targets, likelihood)
    exact = (
        gpytorch.settings.fast_computations(False, False, False),
        gpytorch.settings.max_cholesky_size(10**4),
    )
    with exact[0], exact[1], torch.no_grad():
        model.train()
        marginal = gpytorch.mlls.ExactMarginalLogLikelihood(likelihood, model)
        expected_likelihood = S * marginal(model(inputs), targets).item()
        model.eval()
        latent = model(torch.tensor(embedded(kernel, star)))
    mu, sigma, value = ours(kernel, theta, X, y, star)
    np.testing.assert_allclose(mu, latent.mean.numpy(), atol=1e-10, rtol=0)
    np.testing.assert_allclose(sigma, latent.stddev.numpy(), atol=1e-10, rtol=0)
    assert value == pytest.approx(expected_likelihood, abs=1e-9)


def torch_kernel(kernel, theta, A, B):
    """The kernel written once more, for autograd."""
    import torch

    def g(delta, rho, nu):
        r = delta.abs() / rho
        if np.isinf(nu):
            return torch.exp(-(r**2) / 2)
        a = np.sqrt(2 * nu) * r
        return {0.5: 1.0, 1.5: 1.0 + a, 2.5: 1.0 + a + a**2 / 3}[nu] * torch.exp(-a)

    rho = theta[:3].exp()
    delta = A[:, None] - B[None]
    kappa = torch.sin(np.pi * delta[..., 0]) / np.pi if kernel.kappa == "periodic" else delta[..., 0]
    by_kappa, by_d = g(kappa, rho[0], NU[type(kernel)]), g(delta[..., 1], rho[1], NU[type(kernel)])
    space = by_kappa + by_d if isinstance(kernel, Matern52Sum) else by_kappa * by_d
    time = g(delta[..., 2], rho[2], TIME_NU[kernel.time]) if kernel.time in TIME_NU else 1.0
    return (2 * theta[3]).exp() * space * time


@pytest.mark.parametrize("S", [10, 200])
@pytest.mark.parametrize("kernel", KERNELS, ids=str)
def test_gradients_against_autograd(kernel, S):
    import torch

    theta, (X, y) = theta_of(kernel), samples(S, seed=S)
    _, gradient = log_likelihood(kernel, theta, Zero(), kernel.distances(X), y)
    t_theta, t_X, t_y = torch.tensor(theta, requires_grad=True), torch.tensor(X), torch.tensor(y)
    K = torch_kernel(kernel, t_theta, t_X, t_X) + (2 * t_theta[4]).exp() * torch.eye(S, dtype=torch.float64)
    torch.distributions.MultivariateNormal(torch.zeros(S, dtype=torch.float64), K).log_prob(t_y).backward()
    expected = t_theta.grad.numpy()
    np.testing.assert_allclose(gradient, expected, rtol=1e-8, atol=1e-8)

    U = np.random.default_rng(1).random((5, 2))
    *_, dmu, dsigma = Posterior.of(kernel, theta, Zero(), X, y, 1.0).at(S + 1.0).gradient(U)
    t_U = torch.tensor(U, requires_grad=True)
    K, star = K.detach(), torch.column_stack([t_U, torch.full((5,), S + 1.0, dtype=torch.float64)])
    k = torch_kernel(kernel, t_theta.detach(), star, t_X)
    mu = k @ torch.linalg.solve(K, t_y)
    prior = kernel.prior_variance(theta)
    sigma = (prior - (k * torch.linalg.solve(K, k.T).T).sum(1)).sqrt()
    np.testing.assert_allclose(
        dmu, torch.autograd.grad(mu.sum(), t_U, retain_graph=True)[0], rtol=1e-8, atol=1e-8
    )
    np.testing.assert_allclose(dsigma, torch.autograd.grad(sigma.sum(), t_U)[0], rtol=1e-8, atol=1e-8)
