"""Entities `camera/*`: the bottom view with everything that is known of it drawn on top."""

import numpy as np
import rerun as rr

from deformpush import palette
from deformpush.record.push_record import Decision, PushRecord, RunInfo

EFFECTIVE_DOTS = 100
"""Dots the effective contour is drawn with, each in the colour of its kappa."""


class BottomView:
    """Contour, goal, effective contour, next push and trail of centroids.

    Everything is in pixels of the recorded picture, with the corner of its first pixel as origin. Styles are
    logged once, only positions change. The picture itself is the stream's.
    """

    def __init__(self, width: int) -> None:
        """`width` of the recorded picture in pixels."""
        self._width = width
        self._trail: list[np.ndarray] = []

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log the goal and how the rest is drawn."""
        self._camera = info.camera
        self._scale = self._width / info.camera.pixels
        line, dots = rr.LineStrips2D.from_fields, rr.Points2D.from_fields
        kappa = palette.ramp(np.linspace(0, 1, EFFECTIVE_DOTS), palette.ALONG)
        styles = {
            "goal": line(
                strips=[self._px(_closed(info.goal_outline))], colors=palette.GOAL, radii=-2.0, draw_order=10
            ),
            "goal/centroid": dots(
                positions=[self._px(info.goal_c)], colors=palette.GOAL, radii=-4.0, draw_order=11
            ),
            "contour": line(colors=palette.CONTOUR, radii=-1.0, draw_order=13),
            "effective": dots(colors=kappa, radii=-1.5, draw_order=12),
            "trail": line(colors=palette.TRAIL, radii=-1.0, draw_order=14),
            "next_push/start": dots(colors=palette.NEXT_PUSH, radii=-4.0, draw_order=31),
            "next_push/arrow": rr.Arrows2D.from_fields(colors=palette.NEXT_PUSH, radii=-1.5, draw_order=30),
        }
        for name, style in styles.items():
            rec.log(f"camera/{name}", style, static=True)

    def decide(self, rec: rr.RecordingStream, decision: Decision) -> None:
        """Log where the next push may act (effective contour, coloured by kappa) and where it will."""
        if decision.effective is not None:
            dots = self._px(evenly(decision.effective, EFFECTIVE_DOTS))
            rec.log("camera/effective", rr.Points2D.from_fields(positions=dots))
        if decision.start is not None and decision.end is not None:
            start, end = self._px(decision.start), self._px(decision.end)
            rec.log("camera/next_push/start", rr.Points2D.from_fields(positions=[start]))
            arrow = rr.Arrows2D.from_fields(origins=[start], vectors=[end - start])
            rec.log("camera/next_push/arrow", arrow)

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log contour and trail, and take away what belonged to the push that was made."""
        view = record.after
        rec.log("camera/contour", rr.LineStrips2D.from_fields(strips=[self._px(_closed(view.contour))]))
        self._trail.append(self._px(view.c))
        rec.log("camera/trail", rr.LineStrips2D.from_fields(strips=[np.array(self._trail)]))
        rec.log("camera/next_push", rr.Clear(recursive=True))
        rec.log("camera/effective", rr.Clear(recursive=False))

    def _px(self, points: np.ndarray) -> np.ndarray:
        return np.asarray((self._camera.to_px(points) + 0.5) * self._scale)


def evenly(line: np.ndarray, n: int) -> np.ndarray:
    """N points `(n, 2)` at equal distances along a line `(M, 2)`, ends included."""
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    at = np.linspace(0, along[-1], n)
    return np.stack([np.interp(at, along, line[:, 0]), np.interp(at, along, line[:, 1])], 1)


def _closed(points: np.ndarray) -> np.ndarray:
    return np.vstack([points, points[:1]])
