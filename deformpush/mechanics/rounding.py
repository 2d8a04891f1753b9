"""Rounding where numbers change hands, so that the last bit of a sum decides nothing.

Processors add up in different orders, and their libraries take different roads to a sine or an inverse: the
same sum differs by some 1e-16 from machine to machine. A contact simulation amplifies that: of ten pushes
made twice, one kappa changed by 2e-16, the states lay 3 mm apart after the third. So what passes from the
camera to the optimizer, from there to the robot, and from one decision to the next is rounded: far more
coarsely than the noise it carries (noise decides only on the brink between two values, which is met as often
as noise over resolution), and far more finely than matters. What is made of rounded numbers one by one, by
sums, products, quotients and square roots, needs no rounding: IEEE 754 leaves them one result.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

METRES = 7
"""Decimals of lengths and coordinates (m): 0.1 um, a thousandth of what a camera or a robot resolves."""
NODES = 9
"""Decimals of the nodes of an undeformed mesh (m), which engines are given as text."""
RADIANS = 8
"""Decimals of angles (rad): a nanometre at a lever of 0.1 m."""
JOINTS = 7
"""Decimals of the angles of an arm's joints (rad): 0.1 um at a lever of 1 m."""
KAPPA = 5
"""Decimals of a place on the effective contour (-): 5 um where that is half a metre long."""
DISTANCE = 6
"""Decimals of the length of a push (m): 1 um.

A search ends where the acquisition is flat or has a kink, up to 1e-8 from where it ends on another machine:
hence these two are coarser than other lengths.
"""
METRES_PER_SECOND = 6
"""Decimals of speeds (m/s)."""
STRAINS = 9
"""Decimals of strains (-)."""
NEWTONS = 6
"""Decimals of forces (N)."""
LOGARITHMS = 6
"""Decimals of the logarithm of a hyper-parameter: the data tell it to one decimal."""
REPORTED = 7
"""Significant digits of what is written down of a model's expectations: nothing is computed from them."""
TIE = 1e-8
"""Values that differ by less than this share of the largest are alike, and the first of them is chosen.

Pushes that mirror one another are as good as one another, but for the last bit.
"""


def rounded(x: Array | float, decimals: int) -> Array:
    """To so many decimals; one of the names above says how many and why."""
    return np.asarray(np.round(x, decimals))


def push(U: Array) -> Array:
    """Pushes (kappa, d) `(..., 2)`, d in metres."""
    return np.stack([rounded(U[..., 0], KAPPA), rounded(U[..., 1], DISTANCE)], axis=-1)


def direction(v: Array) -> Array:
    """The unit vector `(2,)` along v `(2,)`, to 1e-9; of length 1 to the last bit."""
    x, y = rounded(v / length(v), 9)
    return np.array([x, y]) / np.sqrt(x * x + y * y)


def length(v: Array) -> float:
    """Length of a vector `(2,)`, without the linear algebra that adds up differently elsewhere."""
    x, y = v
    return float(np.sqrt(x * x + y * y))


def reported(x: float) -> float:
    """A number for the record."""
    return float(f"{x:.{REPORTED}g}")


def lowest(values: Array) -> int:
    """Index of the lowest of values `(n,)`, of the first of those that are alike; nan does not count."""
    finite = np.abs(values[np.isfinite(values)])
    tie = TIE * float(finite.max(initial=0.0))
    return int(np.argmax(values <= np.nanmin(values) + tie))


def lowest_first(values: Array) -> NDArray[np.intp]:
    """Indices of values `(n,)` from the lowest to the highest; of those alike the first comes first."""
    finite = np.abs(values[np.isfinite(values)])
    tie = TIE * float(finite.max(initial=0.0))
    return np.argsort(np.round(values / tie) if tie > 0 else values, kind="stable")
