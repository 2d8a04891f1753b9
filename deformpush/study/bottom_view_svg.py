"""A bottom view as SVG: the picture with goal, contour, trail and next push drawn on it, in pixels."""

from collections.abc import Sequence

import numpy as np

from deformpush.record import palette
from deformpush.record.poses import Trace
from deformpush.study.chart import css
from deformpush.study.page import picture

Array = np.ndarray

MARGIN_PX = 14


Box = tuple[float, float, float, float]
"""Left, top, width, height (px)."""


def svg(trace: Trace, k: int, jpeg: bytes, seen: Box, share: float = 1.0) -> str:
    """The state after push k.

    Args:
        trace: contours, goal and paths of the run.
        k: the push.
        jpeg: the picture, of any size.
        seen: the part of the picture to show.
        share: thickness of the marks; small views want thicker ones.
    """
    x, y, width, height = seen
    n = trace.camera.pixels
    goal, outline = points(trace, trace.goal_outline), points(trace, trace.contours[k])
    trail = points(trace, trace.centroids[: k + 1])
    red, thick = css(palette.NEXT_PUSH), 1.5 * share
    return (
        f'<svg viewBox="{x:.0f} {y:.0f} {width:.0f} {height:.0f}" role="img" aria-label="bottom view">'
        f'<image id="picture" href="{picture(jpeg, "jpeg")}" width="{n}" height="{n}"/>'
        f'<polygon points="{goal}" fill="none" stroke="{css(palette.GOAL)}" stroke-width="{2 * thick}"/>'
        f'<polygon id="contour" points="{outline}" fill="none" stroke="{css(palette.CONTOUR)}" '
        f'stroke-width="{thick}"/>'
        f'<polyline id="trail" points="{trail}" fill="none" stroke="{css(palette.TRAIL)}" '
        f'stroke-width="{thick}"/>'
        f'<g id="push" style="display:none"><circle id="start" r="4" fill="{red}"/>'
        f'<path id="arrow" fill="none" stroke="{red}" stroke-width="2.5" stroke-linejoin="round"/></g></svg>'
    )


def small(trace: Trace, k: int, jpeg: bytes, seen: Box) -> str:
    """As `svg`, without the names by which a script finds the parts: for many on one page."""
    text = svg(trace, k, jpeg, seen, share=1.6)
    for name in ("picture", "contour", "trail", "push", "start", "arrow"):
        text = text.replace(f' id="{name}"', "")
    return text


def bounds(traces: Sequence[Trace]) -> Box:
    """The part of the picture where the objects of these runs were and shall be."""
    places = [
        one.camera.to_picture(np.concatenate([one.goal_outline, *one.contours, one.starts[1:]]))
        for one in traces
    ]
    px = np.concatenate(places)
    px = px[np.isfinite(px).all(1)]
    low, high = px.min(0) - MARGIN_PX, px.max(0) + MARGIN_PX
    side = float((high - low).max())
    left, top = (low + high - side) / 2
    return left, top, side, side


def points(trace: Trace, line: Array) -> str:
    """Points `(M, 2)` in metres as SVG writes them, in pixels."""
    px = trace.camera.to_picture(line)
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in px)
