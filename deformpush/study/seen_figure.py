"""A picture, and drawn on it what is seen in it: the outline, its middle and its axis."""

import io

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from deformpush.record import palette
from deformpush.record.palette import unit
from deformpush.study.run_figure import STYLE

Array = np.ndarray

WIDTH, DPI = 6.4, 200
"""Inches and dots per inch of the figure."""


def draw(picture: Array, contour: Array, middle: Array, theta: float, lines: list[tuple[str, str]]) -> bytes:
    """The figure as a PNG.

    Args:
        picture: RGB `(H, W, 3)` uint8.
        contour: what is seen `(M, 2)` (px; x to the right, y down).
        middle: its centroid `(2,)` (px).
        theta: its orientation (rad, counter-clockwise as one sees it).
        lines: what is told beside it: names and values.
    """
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure(picture, contour, middle, theta, lines).savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def figure(
    picture: Array, contour: Array, middle: Array, theta: float, lines: list[tuple[str, str]]
) -> Figure:
    """The picture with the outline over it, and what is told, below."""
    high, wide = picture.shape[:2]
    told = 0.2 * len(lines) + 0.15
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
    reach = 0.55 * float(np.ptp((contour - middle) @ (np.cos(theta), -np.sin(theta))))
    tip = middle + reach * np.array([np.cos(theta), -np.sin(theta)])
    for colour, width in (((255, 255, 255), 3.4), (palette.INK, 1.5)):
        arrow = {"arrowstyle": "-|>", "color": unit(colour), "linewidth": width, "shrinkA": 0, "shrinkB": 0}
        axis.annotate("", xy=(tip[0], tip[1]), xytext=(middle[0], middle[1]), arrowprops=arrow)
        axis.plot(*middle, "o", color=unit(colour), markersize=2.4 * width)
    axis.set(xlim=(-0.5, wide - 0.5), ylim=(high - 0.5, -0.5))
    axis.set_axis_off()
    for n, (name, value) in enumerate(lines):
        at = share * (1 - (n + 0.75) / (len(lines) + 0.5))
        made.text(0.02, at, name, color=unit(palette.LABEL), va="center")
        made.text(0.14, at, value, color=unit(palette.INK), va="center")
    return made
