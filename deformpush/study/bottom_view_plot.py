"""A bottom view in a matplotlib figure: the picture with goal, contour and next push, in metres."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrow, Polygon

from deformpush.record import palette
from deformpush.record.palette import unit
from deformpush.study.run_data import RunData

Array = np.ndarray

ROOM_M = 0.02
ARROW_M = 0.004
"""Width of the arrow's shaft; its head is four times as wide and, at most, six times as long."""
CLEAR = (20.0, 70.0)
"""How far from white the darkest channel of a pixel is that just shows, and of one that is opaque: what JPEG
leaves around the object shows nowhere."""


def plot(axis: Axes, run: RunData, k: int, thick: float = 1.0) -> None:
    """The bottom view after push k, with the next push; lines are `thick` times as thick as on paper."""
    poses, camera = run.poses, run.poses.camera
    low, high = camera.to_m(np.array([[-0.5, camera.pixels - 0.5], [camera.pixels - 0.5, -0.5]]))
    extent = (low[0], high[0], low[1], high[1])
    outline, contour = poses.goal_outline, poses.contours[k]
    goal, edge = unit(palette.GOAL), unit(palette.CONTOUR)
    axis.add_patch(Polygon(outline, facecolor=unit(palette.lighter(palette.GOAL, 0.6)), zorder=0))
    axis.imshow(transparent(run.pictures[k]), extent=extent, interpolation="bicubic", zorder=1)
    axis.add_patch(Polygon(outline, facecolor="none", edgecolor=goal, linewidth=1.2 * thick))
    axis.add_patch(Polygon(contour, facecolor="none", edgecolor=edge, linewidth=0.9 * thick))
    if k < run.last:
        _next_push(axis, poses.starts[k + 1], poses.ends[k + 1], thick)
    axis.set(xticks=[], yticks=[])
    axis.spines[:].set_visible(True)
    axis.spines[:].set_color("0.6")


def show_square(axis: Axes, square: tuple[Array, float]) -> None:
    """Show what lies within a square: its middle `(2,)` and half its side (m)."""
    middle, half = square
    axis.set(xlim=middle[0] + np.array([-half, half]), ylim=middle[1] + np.array([-half, half]))


def square_around(run: RunData, moments: Sequence[int]) -> tuple[Array, float]:
    """Middle `(2,)` and half side (m) of the square that holds goal, pushes and the object at these k."""
    poses = run.poses
    seen = np.concatenate([poses.goal_outline, *(poses.contours[k] for k in moments), poses.starts[1:]])
    low, high = np.nanmin(seen, 0), np.nanmax(seen, 0)
    return (low + high) / 2, float(np.max(high - low) / 2 + ROOM_M)


def transparent(picture: Array) -> Array:
    """The picture `(H, W, 4)` with its white ground taken away, so that the goal can lie below the object."""
    begins, opaque = CLEAR
    alpha = np.clip((255.0 - picture.min(-1) - begins) / (opaque - begins), 0, 1) * 255
    return np.dstack([picture, alpha.astype(np.uint8)])


def _next_push(axis: Axes, start: Array, end: Array, thick: float) -> None:
    red = unit(palette.NEXT_PUSH)
    arrow = FancyArrow(
        *start,
        *(end - start),
        width=ARROW_M,
        head_width=4 * ARROW_M,
        head_length=min(6 * ARROW_M, float(np.linalg.norm(end - start))),
        length_includes_head=True,
        color=red,
        linewidth=0,
    )
    axis.add_patch(arrow)
    axis.plot(*start, "o", color=red, markersize=3.5 * thick)
