"""Ask/tell optimizers for pushes u = (kappa, d); none of them knows a simulator."""

from deformpush.gp import (
    MAP,
    Constant,
    Correlation,
    Fixed,
    FormulaKernel,
    Matern32,
    Matern52,
    Matern52Sum,
    SquaredExponential,
    Zero,
)
from deformpush.optimizer.abo import ABO
from deformpush.optimizer.acquisition import EI, LCB, PI, Acquisition, LCBSchedule, Thompson
from deformpush.optimizer.base import Components, Optimizer
from deformpush.optimizer.bounds import Adaptive, Box, TrustRegion
from deformpush.optimizer.design import LHS, Random, Sobol
from deformpush.optimizer.minimiser import BFGS, Adam, TorchAdam
from deformpush.optimizer.rivals.botorch_gp import BoTorch
from deformpush.optimizer.rivals.cma_es import CMAES
from deformpush.optimizer.rivals.greedy import Greedy
from deformpush.optimizer.rivals.optuna_gp import OptunaGP
from deformpush.optimizer.rivals.oracle import Oracle
from deformpush.optimizer.rivals.random_push import RandomPush
from deformpush.optimizer.safe import Safe, SafeLCB
from deformpush.state import Proposal, State

__all__ = [
    "ABO",
    "BFGS",
    "CMAES",
    "EI",
    "LCB",
    "LHS",
    "MAP",
    "PI",
    "Acquisition",
    "Adam",
    "Adaptive",
    "BoTorch",
    "Box",
    "Components",
    "Constant",
    "Correlation",
    "Fixed",
    "FormulaKernel",
    "Greedy",
    "LCBSchedule",
    "Matern32",
    "Matern52",
    "Matern52Sum",
    "Optimizer",
    "OptunaGP",
    "Oracle",
    "Proposal",
    "Random",
    "RandomPush",
    "Safe",
    "SafeLCB",
    "Sobol",
    "SquaredExponential",
    "State",
    "Thompson",
    "TorchAdam",
    "TrustRegion",
    "Zero",
]
