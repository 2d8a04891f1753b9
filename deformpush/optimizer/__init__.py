"""Ask/tell optimizers for pushes u = (kappa, d); none of them knows a simulator."""

from deformpush.optimizer.abo import ABO
from deformpush.optimizer.acquisition import LCB
from deformpush.optimizer.bounds import Adaptive, Box
from deformpush.optimizer.design import LHS, Random, Sobol
from deformpush.optimizer.minimiser import Adam
from deformpush.optimizer.protocol import Optimizer, Parts, Proposal

__all__ = [
    "ABO",
    "LCB",
    "LHS",
    "Adam",
    "Adaptive",
    "Box",
    "Optimizer",
    "Parts",
    "Proposal",
    "Random",
    "Sobol",
]
