"""A correlation function given by its formula alone: all it takes to bring a kernel of one's own.

    @dataclass(frozen=True)
    class RationalQuadratic(Correlation):
        alpha: Annotated[float, Gt(0)] = 1.0
        learnt: ClassVar[Mapping[str, LogNormal]] = {"alpha": (1.0, 3.0)}

        def __call__(self, r):
            return (1.0 + r**2 / (2.0 * self.alpha)) ** -self.alpha

    FormulaKernel(space=RationalQuadratic())  # over kappa and d
    Matern52(time=RationalQuadratic())  # over time

Its derivatives are differences of the formula, so it costs some ten times what the built-in ones do.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Self

import numpy as np
from annotated_types import Interval

from deformpush.gp.profiles import Array

LogNormal = tuple[Annotated[float, Interval(ge=1e-4, le=1e6)], Annotated[float, Interval(gt=1, le=1e3)]]
"""(median, factor): 68 % of the prior lies within median / factor and median * factor."""

STEP = 1e-3
"""Of the differences: their error is about 1e-12."""


@dataclass(frozen=True)
class Correlation:
    """How alike pushes are at a distance: fields, and one formula of them.

    The formula must be positive definite, and smooth where it stands for kappa and d.
    """

    learnt: ClassVar[Mapping[str, LogNormal]] = {}
    """Positive fields that are learnt from the pushes beside the length scales, and the prior of each."""

    def __call__(self, r: Array) -> Array:
        """Correlation at distances r >= 0 in units of the length scale, any shape; 1 at r = 0."""
        raise NotImplementedError

    def plane(self, r: Array) -> Array:
        """Correlation over kappa and d together, at distances r `(2, ...)`: the product, as eq. (7) has it.

        One may write it differently, as in `return self(np.hypot(*r))`.
        """
        return self(r[0]) * self(r[1])

    @property
    def log_values(self) -> list[float]:
        """Logarithms of the fields that are learnt."""
        return [float(np.log(getattr(self, name))) for name in self.learnt]

    def at(self, log_values: Array) -> Self:
        """The same with other values of the fields that are learnt."""
        return replace(self, **dict(zip(self.learnt, np.exp(log_values).tolist(), strict=True)))

    def check(self, field: str, coordinates: int) -> None:
        """Check the formula at distance 0, over one coordinate or two.

        Raises:
            ValueError: there is none, or it is not 1 there; the message starts with the field of the kernel.
        """
        name = type(self).__name__
        if type(self).__call__ is Correlation.__call__:
            raise ValueError(f"{field}: {name} must define __call__(self, r)")
        value = self(np.zeros(1)) if coordinates == 1 else self.plane(np.zeros((2, 1)))
        if not np.allclose(value, 1.0):
            raise ValueError(f"{field}: {name} is {float(value[0]):g} at distance 0, must be 1")


def slope(f: Callable[[Array], Array], x: Array, along: Array) -> Array:
    """Derivative of f at x, in units of the vector `along`, by five-point differences."""
    near, far = f(x + STEP * along) - f(x - STEP * along), f(x + 2 * STEP * along) - f(x - 2 * STEP * along)
    return np.asarray((8.0 * near - far) / (12.0 * STEP))
