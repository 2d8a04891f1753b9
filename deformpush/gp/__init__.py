"""Gaussian process over (kappa, d, t): kernels (7)-(8), regression (9)-(11), hyper-parameters."""

from deformpush.gp.fit import MAP, Fixed
from deformpush.gp.kernels import Kernel, Matern32, Matern52, Matern52Sum, SquaredExponential
from deformpush.gp.means import Constant, Zero
from deformpush.gp.regression import Posterior, Surface
from deformpush.gp.regressor import Regressor

__all__ = [
    "MAP",
    "Constant",
    "Fixed",
    "Kernel",
    "Matern32",
    "Matern52",
    "Matern52Sum",
    "Posterior",
    "Regressor",
    "SquaredExponential",
    "Surface",
    "Zero",
]
