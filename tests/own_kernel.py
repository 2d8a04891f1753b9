"""A kernel with one more number to learn, as a user would write it: one class, one formula."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from annotated_types import Gt

from deformpush.gp import Correlation, LogNormal


@dataclass(frozen=True)
class RationalQuadratic(Correlation):
    """(1 + r^2 / (2 alpha))^-alpha: squared exponentials of many length scales, added up."""

    alpha: Annotated[float, Gt(0)] = 1.0
    learnt: ClassVar[Mapping[str, LogNormal]] = {"alpha": (1.0, 3.0)}

    def __call__(self, r: np.ndarray) -> np.ndarray:
        return (1.0 + r**2 / (2.0 * self.alpha)) ** -self.alpha
