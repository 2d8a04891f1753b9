"""A chart as HTML: lines in an SVG that stretches to any width, with text beside it that does not."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Literal

import numpy as np

from deformpush.record.palette import Colour

Array = np.ndarray
Kind = Literal["line", "dots", "area"]

DOT, SMALL = 6.0, 3.0
"""Diameter of a dot (px), and of one among many."""
MANY = 300
"""Beyond so many pushes dots of the usual size would cover one another."""


@dataclass(frozen=True)
class Mark:
    """What a chart shows: finite values over k."""

    kind: Kind
    k: Array
    values: Array
    """One for each of `k`; an area goes along its lower edge and back along the upper one."""
    colour: Colour
    style: str
    """Further attributes of the SVG path."""
    key: str
    """Its name above the chart, or nothing."""


@dataclass
class Chart:
    """Marks over k = 0 ... `last`; values that are not finite are left out."""

    title: str
    last: int
    marks: list[Mark] = field(default_factory=list)
    initial: int = 0
    """Pushes of the initial design, which are shaded."""

    def line(
        self, values: Array, colour: Colour, key: str = "", width: float = 2.0, dashes: str = ""
    ) -> None:
        """Add a line `(K+1,)`; `key` names it above the chart."""
        style = f'fill="none" stroke="{css(colour)}" stroke-width="{width}" stroke-dasharray="{dashes}"'
        self._add("line", np.arange(len(values)), values, colour, style, key)

    def steps(self, values: Array, colour: Colour, key: str = "", width: float = 2.0) -> None:
        """Add a line `(K+1,)` that keeps each value until the next."""
        style = f'fill="none" stroke="{css(colour)}" stroke-width="{width}"'
        k = np.repeat(np.arange(len(values)), 2)
        self._add("line", k[1:], np.repeat(values, 2)[:-1], colour, style, key)

    def dots(self, values: Array, colour: Colour, key: str = "") -> None:
        """Add a dot for each value `(K+1,)`."""
        width = DOT if self.last <= MANY else SMALL
        style = f'stroke="{css(colour)}" stroke-width="{width}" stroke-linecap="round"'
        self._add("dots", np.arange(len(values)), values, colour, style, key)

    def band(self, low: Array, high: Array, colour: Colour, key: str = "") -> None:
        """Fill between two curves `(K+1,)`."""
        k = np.arange(len(low))
        known = np.isfinite(low) & np.isfinite(high)
        values = np.concatenate([low[known], high[known][::-1]])
        style = f'fill="{css(colour)}" fill-opacity="0.22" stroke="none"'
        self._add("area", np.concatenate([k[known], k[known][::-1]]), values, colour, style, key)

    def stop(self, value: float, colour: Colour) -> None:
        """Add a level that is to be reached."""
        if np.isfinite(value):
            self.line(np.full(self.last + 1, value), colour, f"stop {value:.3g}", 1.2, "5 4")

    def html(self) -> str:
        """The chart as a figure."""
        values = np.concatenate([np.zeros(0), *(mark.values for mark in self.marks)])
        low, high = (values.min(), values.max()) if len(values) else (0.0, 1.0)
        pad = 0.05 * (high - low) or 0.5
        bottom = 0.0 if 0 <= low <= 0.5 * high else low - pad
        top = high + pad

        def y(value: float) -> float:
            return 100 * (top - value) / (top - bottom)

        shade = f'<rect class="initial" x="0" y="0" width="{self._x(self.initial):.2f}" height="100"/>'
        levels = ticks(bottom, top, 4)
        grid = "".join(f'<path class="grid" d="M0 {y(t):.2f}H100"/>' for t in levels)
        body = "".join(self._path(mark, [y(value) for value in mark.values]) for mark in self.marks)
        ys = "".join(f'<span style="top:{y(t):.2f}%">{t:g}</span>' for t in levels)
        xs = "".join(f'<span style="left:{self._x(t):.2f}%">{t:g}</span>' for t in ticks(0, self.last, 8))
        keys = "".join(
            f'<span><i style="background:{css(mark.colour)}"></i>{escape(mark.key)}</span>'
            for mark in self.marks
            if mark.key
        )
        return (
            f'<figure class="chart"><figcaption><b>{escape(self.title)}</b>{keys}</figcaption>'
            f'<div class="plot"><svg viewBox="0 0 100 100" preserveAspectRatio="none" role="img" '
            f'aria-label="{escape(self.title)} by push">{shade if self.initial else ""}{grid}{body}</svg>'
            f'<i class="cursor"></i><div class="ys">{ys}</div>'
            f'<div class="xs"><b>push</b>{xs}</div></div></figure>'
        )

    def _add(self, kind: Kind, k: Array, values: Array, colour: Colour, style: str, key: str) -> None:
        known = np.isfinite(values)
        if known.any():
            self.marks.append(Mark(kind, k[known], values[known], colour, style, key))

    def _path(self, mark: Mark, y: Iterable[float]) -> str:
        places = [f"{self._x(one):.2f} {at:.2f}" for one, at in zip(mark.k, y, strict=True)]
        if mark.kind == "dots":
            path = "".join(f"M{place}h0" for place in places)
        else:
            path = "M" + "L".join(places) + ("Z" if mark.kind == "area" else "")
        return f'<path d="{path}" {mark.style}/>'

    def _x(self, k: float) -> float:
        return 100 * k / max(self.last, 1)


def ticks(low: float, high: float, about: int) -> Sequence[float]:
    """Round values between `low` and `high`, nearly `about` of them."""
    raw = max(high - low, 1e-12) / about
    step = 10.0 ** np.floor(np.log10(raw))
    step *= next(factor for factor in (1, 2, 5, 10) if factor * step >= raw)
    if float(high).is_integer() and low == 0 and about == 8:
        step = max(step, 1.0)
    return [round(float(t), 10) for t in np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step]


def css(colour: Colour) -> str:
    """A colour as CSS writes it."""
    r, g, b = colour
    return f"rgb({r},{g},{b})"
