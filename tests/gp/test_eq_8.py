"""Why eq. (8) is not offered as it is printed."""

import numpy as np

from deformpush.gp import Matern52, Matern52Sum

from .cases import samples


def printed(X, rho, s2):
    """sum_i (s2 + a_i + a_i^2 / 3 exp(-a_i)), a_i = sqrt(5) |x_i - x_i'| / rho_i."""
    a = np.sqrt(5) * np.abs(X[:, None] - X[None]) / rho
    return np.sum(s2 + a + a**2 / 3 * np.exp(-a), axis=-1)


def test_the_printed_formula_is_no_kernel_and_its_readings_are():
    X, _ = samples(20, seed=0)
    rho = np.array([0.3, 0.5, 20.0])
    for s2 in (0.25, 1.0, 4.0):
        K = printed(X, rho, s2)
        eigenvalues = np.linalg.eigvalsh(K)
        assert eigenvalues[0] < -0.01 * eigenvalues[-1]
        assert K.max() > K[0, 0], "it grows with distance"
        for kernel in (
            Matern52(sigma_f=np.sqrt(s2), kappa="open"),
            Matern52Sum(sigma_f=np.sqrt(s2), kappa="open"),
        ):
            theta = kernel.theta()
            K = np.zeros((20, 20))
            K[np.tril_indices(20, -1)] = kernel.gram(theta, kernel.distances(X))
            K += K.T + kernel.prior_variance(theta) * np.eye(20)
            assert np.linalg.eigvalsh(K)[0] > 0
