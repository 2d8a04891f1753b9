"""Ask/tell optimizers for pushes u = (kappa, d); none of them knows a simulator."""

from deformpush.gp import MAP, Constant, Fixed, Matern32, Matern52, Matern52Sum, SquaredExponential, Zero
from deformpush.optimizer.abo import ABO
from deformpush.optimizer.acquisition import EI, LCB, PI, LCBSchedule, Thompson
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
from deformpush.state import Proposal

__all__ = [
    "ABO",
    "BFGS",
    "CMAES",
    "EI",
    "LCB",
    "LHS",
    "MAP",
    "PI",
    "Adam",
    "Adaptive",
    "BoTorch",
    "Box",
    "Constant",
    "Fixed",
    "Greedy",
    "LCBSchedule",
    "Matern32",
    "Matern52",
    "Matern52Sum",
    "Optimizer",
    "OptunaGP",
    "Oracle",
    "Parts",
    "Proposal",
    "Random",
    "RandomPush",
    "Sobol",
    "SquaredExponential",
    "Thompson",
    "TorchAdam",
    "TrustRegion",
    "Zero",
]
