"""Which points of a contour a tool can push at all, on its straight way."""

import numpy as np

Array = np.ndarray

EARLY = 0.25
"""The tool may be stopped this far before a point (of its reach). In a corner of 106 degrees it is."""
LATE = 1.0
"""And touch this far behind it (of its reach): it passes a corner of the object at its side."""


def pushable(contour: Array, start: Array, direction: Array, reach: float, approach: float = np.inf) -> Array:
    """Whether the first that the tool touches is the contour point that it is meant to push: bool `(M,)`.

    It is not in a concave corner too narrow for the tool, nor where another part of the object is in the way.

    Args:
        contour: `(M, 2)` (m).
        start: a place on the line of each point's push `(M, 2)` (m).
        direction: of each point's push, unit vectors `(M, 2)`.
        reach: distance between the tool's centre and the contour at touch (m).
        approach: straight way of the tool up to the touch (m); what lies farther behind is in nobody's way.
    """
    to = contour - start[:, None]
    along = np.einsum("ijk,ik->ij", to, direction)
    across = to[..., 1] * direction[:, None, 0] - to[..., 0] * direction[:, None, 1]
    half = np.sqrt(np.maximum(reach**2 - across**2, 0.0))
    wanted = np.diag(along) - reach
    met = (np.abs(across) < reach) & (along + half > (wanted - approach)[:, None])
    first = np.where(met, along - half, np.inf).min(axis=1)
    return np.asarray((first >= wanted - EARLY * reach) & (first <= wanted + LATE * reach))
