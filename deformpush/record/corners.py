"""The corner of each strip in which a legend hides least; known once a run has ended."""

from collections.abc import Iterable

import numpy as np
import rerun.blueprint as rrb

WIDE, HIGH = 0.28, 0.5
"""Share of a strip that its legend covers."""
CORNERS = {
    (0, 1): rrb.Corner2D.LeftTop,
    (1, 1): rrb.Corner2D.RightTop,
    (0, 0): rrb.Corner2D.LeftBottom,
    (1, 0): rrb.Corner2D.RightBottom,
}
"""By right or not, top or not; the first of those that are as good is taken."""


class Corners:
    """Keeps what is drawn in each strip."""

    def __init__(self) -> None:
        """Nothing is drawn yet."""
        self._drawn: dict[str, list[tuple[int, float]]] = {}

    def add(self, strip: str, k: int, values: Iterable[float]) -> None:
        """Note what is drawn in a strip at push k."""
        self._drawn.setdefault(strip, []).extend((k, float(value)) for value in values)

    def free(self) -> dict[str, rrb.Corner2D]:
        """The freest corner of each strip in which something is drawn."""
        found = {strip: np.array(drawn) for strip, drawn in self._drawn.items()}
        known = {strip: points[np.isfinite(points[:, 1])] for strip, points in found.items()}
        return {strip: freest(points) for strip, points in known.items() if len(points)}


def freest(points: np.ndarray) -> rrb.Corner2D:
    """The corner with the fewest of the points `(n, 2)`, which span the strip from side to side."""
    low, high = points.min(0), points.max(0)
    share = (points - low) / np.maximum(high - low, 1e-12)

    def hidden(right: int, top: int) -> int:
        x, y = np.abs(share - (right, top)).T
        return int(((x <= WIDE) & (y <= HIGH)).sum())

    return CORNERS[min(CORNERS, key=lambda at: hidden(*at))]
