"""A bottom view as SVG: the picture with goal, contour, trail and next push drawn on it, in pixels."""

from collections.abc import Mapping, Sequence

import numpy as np

from deformpush.record import palette
from deformpush.record.poses import Poses
from deformpush.study.chart import css
from deformpush.study.page import picture

Array = np.ndarray
Box = tuple[float, float, float, float]
"""Left, top, width, height (px)."""

MARGIN_PX = 14
MOVED = ("picture", "contour", "trail")
STILL_THICK = 1.6
"""Marks of a small view against those of a large one."""


def moving(poses: Poses, jpeg: bytes, seen: Box) -> str:
    """The state before the first push, with the names by which page.js finds its parts and moves them.

    Args:
        poses: contours and goal of the run.
        jpeg: the picture, of any size.
        seen: the part of the picture to show.
    """
    red = css(palette.NEXT_PUSH)
    push = (
        f'<g id="push" style="display:none"><circle id="start" r="4" fill="{red}"/>'
        f'<path id="arrow" fill="none" stroke="{red}" stroke-width="2.5" stroke-linejoin="round"/></g>'
    )
    return _svg(poses, 0, jpeg, seen, 1.0, {name: f' id="{name}"' for name in MOVED}, push)


def still(poses: Poses, k: int, jpeg: bytes, seen: Box) -> str:
    """The state after push k, one of many small views on a page; arguments as in `moving`."""
    return _svg(poses, k, jpeg, seen, STILL_THICK, dict.fromkeys(MOVED, ""), "")


def square_around(runs: Sequence[Poses]) -> Box:
    """The part of the picture where the objects of these runs were and shall be."""
    places = [
        one.camera.to_picture(np.concatenate([one.goal_outline, *one.contours, one.starts[1:]]))
        for one in runs
    ]
    px = np.concatenate(places)
    px = px[np.isfinite(px).all(1)]
    low, high = px.min(0) - MARGIN_PX, px.max(0) + MARGIN_PX
    side = float((high - low).max())
    left, top = (low + high - side) / 2
    return left, top, side, side


def points(poses: Poses, line: Array) -> str:
    """Points `(M, 2)` in metres as SVG writes them, in pixels."""
    px = poses.camera.to_picture(line)
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in px)


def _svg(
    poses: Poses, k: int, jpeg: bytes, seen: Box, thick: float, ids: Mapping[str, str], more: str
) -> str:
    x, y, width, height = seen
    n, line = poses.camera.pixels, 1.5 * thick
    goal, outline = points(poses, poses.goal_outline), points(poses, poses.contours[k])
    trail = points(poses, poses.centroids[: k + 1])
    return (
        f'<svg viewBox="{x:.0f} {y:.0f} {width:.0f} {height:.0f}" role="img" aria-label="bottom view">'
        f'<image{ids["picture"]} href="{picture(jpeg, "jpeg")}" width="{n}" height="{n}"/>'
        f'<polygon points="{goal}" fill="none" stroke="{css(palette.GOAL)}" stroke-width="{2 * line}"/>'
        f'<polygon{ids["contour"]} points="{outline}" fill="none" stroke="{css(palette.CONTOUR)}" '
        f'stroke-width="{line}"/>'
        f'<polyline{ids["trail"]} points="{trail}" fill="none" stroke="{css(palette.TRAIL)}" '
        f'stroke-width="{line}"/>{more}</svg>'
    )
