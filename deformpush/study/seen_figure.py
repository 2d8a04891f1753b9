"""A picture, and drawn on it what is seen in it: the outline, its middle and its axis."""

import io
from textwrap import wrap

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from deformpush.record import palette
from deformpush.record.palette import unit
from deformpush.study.run_figure import STYLE

Array = np.ndarray

WIDTH, DPI = 6.4, 200
"""Inches and dots per inch of the figure."""
LETTERS = 96
"""In a line of what is told."""


def draw(
    picture: Array, contour: Array, middle: Array, theta: float | None, lines: list[tuple[str, str]]
) -> bytes:
    """The figure as a PNG.

    Args:
        picture: RGB `(H, W, 3)` uint8.
        contour: what is seen `(M, 2)` (px; x to the right, y down).
        middle: its centroid `(2,)` (px).
        theta: its orientation (rad, counter-clockwise as one sees it); None where it has none.
        lines: what is told beside it: names and values.
    """
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure(picture, contour, middle, theta, lines).savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def figure(
    picture: Array, contour: Array, middle: Array, theta: float | None, lines: list[tuple[str, str]]
) -> Figure:
    """The picture with the outline over it, and what is told, below."""
    high, wide = picture.shape[:2]
    rows = [
        (name if n == 0 else "", part) for name, value in lines for n, part in enumerate(wrap(value, LETTERS))
    ]
    told = 0.2 * len(rows) + 0.15
    height = WIDTH * high / wide
    made = Figure(figsize=(WIDTH, height + told))
    share = told / (height + told)
    axis = made.add_axes((0, share, 1, 1 - share))
    axis.imshow(picture, extent=(-0.5, wide - 0.5, high - 0.5, -0.5), interpolation="nearest")
    closed = np.vstack([contour, contour[:1]])
    for colour, width in (
        ((255, 255, 255), 3.0),
        (palette.NEXT_PUSH, 1.3),
    ):  # a white rim: seen on any ground
        axis.plot(*closed.T, color=unit(colour), linewidth=width, solid_joinstyle="round")
    if theta is not None:
        ahead = np.array([np.cos(theta), -np.sin(theta)])
        x, y = middle + 0.55 * float(np.ptp((contour - middle) @ ahead)) * ahead
        back = middle + 0.9 * (np.array([x, y]) - middle)
        axis.plot([middle[0], back[0]], [middle[1], back[1]], color="white", linewidth=3.4)
        arrow = {
            "arrowstyle": "-|>",
            "color": unit(palette.INK),
            "linewidth": 1.5,
            "shrinkA": 0,
            "shrinkB": 0,
        }
        arrow["mutation_scale"] = 14
        axis.annotate("", xy=(x, y), xytext=(middle[0], middle[1]), arrowprops=arrow)
    axis.plot(*middle, "o", color=unit(palette.INK), markersize=5, markeredgecolor="white")
    axis.set(xlim=(-0.5, wide - 0.5), ylim=(high - 0.5, -0.5))
    axis.set_axis_off()
    for n, (name, value) in enumerate(rows):
        at = share * (1 - (n + 0.75) / (len(rows) + 0.5))
        made.text(0.02, at, name, color=unit(palette.LABEL), va="center")
        made.text(0.14, at, value, color=unit(palette.INK), va="center")
    return made
