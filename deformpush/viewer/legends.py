"""The corner of each strip in which a legend hides least; known once a run has ended."""

from collections.abc import Iterable

import numpy as np
import rerun.blueprint as rrb

WIDE, HIGH = 0.3, 0.6
"""Share of a strip that its legend covers."""
BETWEEN = 8
"""Points on the line from one push to the next that count."""
MOST = 256
"""Points of a line that are kept."""
CORNERS = {
    (0, 1): rrb.Corner2D.LeftTop,
    (1, 1): rrb.Corner2D.RightTop,
    (0, 0): rrb.Corner2D.LeftBottom,
    (1, 0): rrb.Corner2D.RightBottom,
}
"""Corners by (right, top); the first of those that are as good is taken."""


class Line:
    """Points of a line, all of a short one and evenly fewer of a longer one: it takes no more room."""

    def __init__(self) -> None:
        """Begin without a point."""
        self._points: list[tuple[float, float]] = []
        self._every, self._count = 1, 0
        self._last = (np.nan, np.nan)

    def add(self, point: tuple[float, float]) -> None:
        """Note a point, at a larger k than the one before."""
        if self._count % self._every == 0:
            self._points.append(point)
        self._last, self._count = point, self._count + 1
        if len(self._points) == MOST:
            self._points = self._points[::2]
            self._every *= 2

    def points(self) -> np.ndarray:
        """What is known of the line `(n, 2)`, its end included."""
        ended = self._points[-1:] == [self._last]
        return np.array(self._points if ended else [*self._points, self._last])


class Legends:
    """Keeps what is drawn in each strip, roughly where that is long."""

    def __init__(self) -> None:
        """Begin with empty strips."""
        self._drawn: dict[str, dict[str, Line]] = {}

    def add(self, strip: str, k: int, values: Iterable[float], name: str = "") -> None:
        """Note where the lines that share a name in a strip are at push k."""
        lines = self._drawn.setdefault(strip, {})
        for i, value in enumerate(values):
            if np.isfinite(value):
                lines.setdefault(f"{name}{i}", Line()).add((float(k), float(value)))

    def free(self) -> dict[str, rrb.Corner2D]:
        """The freest corner of each strip in which something is drawn."""
        return {
            strip: freest(np.concatenate([_along(line.points()) for line in lines.values()]))
            for strip, lines in self._drawn.items()
            if lines
        }


def _along(line: np.ndarray) -> np.ndarray:
    """Points along a line through `(n, 2)`, evenly many between any two."""
    at = np.linspace(0, len(line) - 1, BETWEEN * (len(line) - 1) + 1)
    return np.stack([np.interp(at, np.arange(len(line)), line[:, i]) for i in (0, 1)], 1)


def freest(points: np.ndarray) -> rrb.Corner2D:
    """The corner with the fewest of the points `(n, 2)`; the strip goes from push 0 to the last."""
    low, high = np.array([0.0, points[:, 1].min()]), points.max(0)
    share = (points - low) / np.maximum(high - low, 1e-12)

    def hidden(right: int, top: int) -> int:
        x, y = np.abs(share - (right, top)).T
        return int(((x <= WIDE) & (y <= HIGH)).sum())

    return CORNERS[min(CORNERS, key=lambda at: hidden(*at))]
