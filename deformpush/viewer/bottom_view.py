"""Entities `camera/*`: the bottom view with everything that is known of it drawn on top."""

from collections import deque

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from deformpush.cell.camera import Camera
from deformpush.push_record import EFFECTIVE_POINTS, Action, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.record.settings import RECENT
from deformpush.viewer.panel import Panel


class BottomView(Panel):
    """Contour, goal, effective contour, next push and trail of the last centroids.

    Everything is in pixels of the recorded picture, with the corner of its first pixel as origin. Styles are
    logged once, only positions change. The picture itself is the stream's.
    """

    def __init__(self, width: int, root: str = "camera") -> None:
        """`width` of the recorded picture in pixels; `root` is the entity everything stands under."""
        self._width, self._root = width, root
        self._trail: deque[np.ndarray] = deque(maxlen=RECENT + 1)

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log the goal and how the rest is drawn."""
        self.lay(rec, info.camera, info.target.outline, info.target.c)

    def lay(
        self, rec: rr.RecordingStream, camera: Camera, goal_outline: np.ndarray, goal_c: np.ndarray
    ) -> None:
        """Log the goal, of outline `(G, 2)` and centroid `(2,)` in metres, and how the rest is drawn."""
        self._camera = camera
        line, dots = rr.LineStrips2D.from_fields, rr.Points2D.from_fields
        kappa = palette.ramp(np.linspace(0, 1, EFFECTIVE_POINTS), palette.ALONG)
        styles = {
            "goal": line(
                strips=[self._px(_closed(goal_outline))], colors=palette.GOAL, radii=-2.0, draw_order=10
            ),
            "goal/centroid": dots(
                positions=[self._px(goal_c)], colors=palette.GOAL, radii=-4.0, draw_order=11
            ),
            "contour": line(colors=palette.CONTOUR, radii=-1.0, draw_order=13),
            "effective": dots(colors=kappa, radii=-1.5, draw_order=12),
            "trail": line(colors=palette.TRAIL, radii=-1.0, draw_order=14),
            "next_push/start": dots(colors=palette.NEXT_PUSH, radii=-4.0, draw_order=31),
            "next_push/arrow": rr.Arrows2D.from_fields(colors=palette.NEXT_PUSH, radii=-1.5, draw_order=30),
        }
        for name, style in styles.items():
            rec.log(f"{self._root}/{name}", style, static=True)

    def decide(self, rec: rr.RecordingStream, action: Action) -> None:
        """Log where the next push may act (effective contour, coloured by kappa) and where it will."""
        if action.effective is not None:
            dots = self._px(action.effective)
            rec.log(f"{self._root}/effective", rr.Points2D.from_fields(positions=dots))
        self.point(rec, action.path.start, action.path.end)

    def point(self, rec: rr.RecordingStream, start: np.ndarray, end: np.ndarray) -> None:
        """Log the next push, from where the tool starts to where it ends, both `(2,)` in metres."""
        start, end = self._px(start), self._px(end)
        rec.log(f"{self._root}/next_push/start", rr.Points2D.from_fields(positions=[start]))
        arrow = rr.Arrows2D.from_fields(origins=[start], vectors=[end - start])
        rec.log(f"{self._root}/next_push/arrow", arrow)

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log contour and trail, and take away what belonged to the push that was made."""
        self.outline(rec, record.view.seen.contour, record.view.seen.c)
        rec.log(f"{self._root}/effective", rr.Clear(recursive=False))

    def outline(self, rec: rr.RecordingStream, contour: np.ndarray, c: np.ndarray) -> None:
        """Log the contour `(M, 2)`, add the centroid to the trail and take away the arrow."""
        rec.log(f"{self._root}/contour", rr.LineStrips2D.from_fields(strips=[self._px(_closed(contour))]))
        self._trail.append(self._px(c))
        rec.log(f"{self._root}/trail", rr.LineStrips2D.from_fields(strips=[np.array(self._trail)]))
        rec.log(f"{self._root}/next_push", rr.Clear(recursive=True))

    def _px(self, points: np.ndarray) -> np.ndarray:
        return self._camera.to_picture(points, self._width)


def around(camera: Camera, width: int, places: np.ndarray, room_m: float) -> rrb.VisualBounds2D:
    """The part of a picture of this width (px) that shows the places `(n, 2)` with some room about them."""
    low, high = np.nanmin(places, 0) - room_m, np.nanmax(places, 0) + room_m
    corners = camera.to_picture(np.stack([low, high]), width)
    (left, top), (right, bottom) = np.clip([corners.min(0), corners.max(0)], 0, width)
    return rrb.VisualBounds2D(x_range=(left, right), y_range=(top, bottom))


def _closed(points: np.ndarray) -> np.ndarray:
    return np.vstack([points, points[:1]])
