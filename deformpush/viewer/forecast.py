"""Entities `camera/forecast`, `motion/*`: where the next push should bring the object, and where it did."""

import numpy as np
import rerun as rr

from deformpush.mechanics.geometry import rotation
from deformpush.push_record import Decision, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.record.forecasts import actual
from deformpush.viewer.legends import Corners
from deformpush.viewer.plots import BAND, PREDICTED

AXIS_M = 0.03
"""Length of the line that shows the predicted angle (m)."""


class Outlook:
    """Ellipse of the predicted centroid, line of the predicted angle; motion as predicted and as it came."""

    def __init__(self, width: int, corners: Corners) -> None:
        """`width` of the recorded picture in pixels; `corners` is told what is drawn where."""
        self._width, self._corners = width, corners

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log how it is drawn."""
        self._camera = info.camera
        self._before = actual(first)
        line = rr.LineStrips2D.from_fields
        rec.log(
            "camera/forecast/centroid", line(colors=palette.FORECAST, radii=-1.5, draw_order=32), static=True
        )
        rec.log(
            "camera/forecast/angle", line(colors=palette.FORECAST, radii=-1.0, draw_order=32), static=True
        )
        for name, title in (("moved", "moved (mm)"), ("turned", "turned (deg)")):
            came = rr.SeriesLines(names=[title], colors=[palette.FORECAST], widths=[1.5])
            rec.log(f"motion/{name}/actual", came, static=True)
            marks = rr.SeriesPoints(names=title, colors=palette.FORECAST, markers="circle", marker_sizes=3.0)
            rec.log(f"motion/{name}/actual", marks, static=True)
            band = rr.SeriesLines(names=[PREDICTED] * 3, colors=[palette.BOUND] * 3, widths=[1.5, 0.75, 0.75])
            rec.log(f"motion/{name}/predicted", band, static=True)

    def decide(self, rec: rr.RecordingStream, decision: Decision) -> None:
        """Log where the push that comes next should bring the object."""
        if decision.forecast is None:
            return
        mean, cov = decision.forecast.mean, decision.forecast.cov
        rec.log(
            "camera/forecast/centroid", rr.LineStrips2D.from_fields(strips=[self._px(ellipse(mean, cov))])
        )
        reach = rotation(mean[2]) @ (AXIS_M, 0.0)
        heading = self._px(np.stack([mean[:2] - reach, mean[:2] + reach]))
        rec.log("camera/forecast/angle", rr.LineStrips2D.from_fields(strips=[heading]))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log the motion beside its forecast, and take away the drawing."""
        rec.log("camera/forecast", rr.Clear(recursive=True))
        before, now = self._before, actual(record)
        self._before = now
        if record.decision is None or record.decision.forecast is None:
            for name in ("moved", "turned"):
                rec.log(f"motion/{name}/actual", rr.Scalars(np.nan))
            return
        mean, cov = record.decision.forecast.mean, record.decision.forecast.cov
        step = mean[:2] - before[:2]
        along = step / max(float(np.linalg.norm(step)), 1e-9)
        spread = float(np.sqrt(along @ cov[:2, :2] @ along))
        pairs = (
            ("moved", 1e3, float((now[:2] - before[:2]) @ along), float(step @ along), spread),
            ("turned", 180 / np.pi, now[2] - before[2], mean[2] - before[2], float(np.sqrt(cov[2, 2]))),
        )
        for name, unit, came, expected, sigma in pairs:
            rec.log(f"motion/{name}/actual", rr.Scalars(unit * came))
            band = unit * (expected + BAND * sigma * np.array([0.0, -1.0, 1.0]))
            rec.log(f"motion/{name}/predicted", rr.Scalars(band))
            self._corners.add(f"motion/{name}", record.k, [unit * came, *band])

    def _px(self, points: np.ndarray) -> np.ndarray:
        return self._camera.to_picture(points, self._width)


def ellipse(mean: np.ndarray, cov: np.ndarray, n: int = 48) -> np.ndarray:
    """Outline `(n + 1, 2)` of the centroid's ellipse at `BAND` standard deviations."""
    values, vectors = np.linalg.eigh(cov[:2, :2])
    angle = np.linspace(0, 2 * np.pi, n + 1)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    return np.asarray(mean[:2] + (BAND * vectors @ (np.sqrt(np.maximum(values, 0))[:, None] * circle)).T)
