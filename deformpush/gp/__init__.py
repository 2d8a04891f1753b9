"""Gaussian process over (kappa, d, t): kernels (7)-(8), regression (9)-(11), hyper-parameters."""

from deformpush.gp.correlation import Correlation, LogNormal
from deformpush.gp.fit import MAP, Fixed
from deformpush.gp.kernels import FormulaKernel, Kernel, Matern32, Matern52, Matern52Sum, SquaredExponential
from deformpush.gp.means import Constant, Zero
from deformpush.gp.regression import Posterior, TimeSlice
from deformpush.gp.regressor import Regressor

__all__ = [
    "MAP",
    "Constant",
    "Correlation",
    "Fixed",
    "FormulaKernel",
    "Kernel",
    "LogNormal",
    "Matern32",
    "Matern52",
    "Matern52Sum",
    "Posterior",
    "Regressor",
    "SquaredExponential",
    "TimeSlice",
    "Zero",
]
