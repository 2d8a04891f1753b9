"""Entities `camera/forecast`, `motion/*`: where the next push should bring the object, and where it did."""

import numpy as np
import rerun as rr

from deformpush.mechanics.geometry import rotation
from deformpush.push_record import Action, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.record.forecasts import actual
from deformpush.viewer.legends import Legends
from deformpush.viewer.panel import Panel
from deformpush.viewer.plots import BAND, PREDICTED

AXIS_M = 0.03
"""Length of the line that shows the predicted angle, from its middle to an end (m)."""
MOTION = {"moved": "moved (mm)", "turned": "turned (deg)"}


class ForecastPanel(Panel):
    """Ellipse of the predicted centroid, line of the predicted angle; motion as predicted and as it came."""

    def __init__(self, width: int, legends: Legends) -> None:
        """`width` of the recorded picture in pixels; `legends` is told what is drawn where."""
        self._width, self._legends = width, legends

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log how it is drawn."""
        self._camera = info.camera
        self._before = actual(first)
        for name, radius in (("centroid", -1.5), ("angle", -1.0)):
            line = rr.LineStrips2D.from_fields(colors=palette.FORECAST, radii=radius, draw_order=32)
            rec.log(f"camera/forecast/{name}", line, static=True)
        for name, title in MOTION.items():
            came = rr.SeriesLines(names=[title], colors=[palette.FORECAST], widths=[1.5])
            rec.log(f"motion/{name}/actual", came, static=True)
            marks = rr.SeriesPoints(names=title, colors=palette.FORECAST, markers="circle", marker_sizes=3.0)
            rec.log(f"motion/{name}/actual", marks, static=True)
            band = rr.SeriesLines(names=[PREDICTED] * 3, colors=[palette.BOUND] * 3, widths=[1.5, 0.75, 0.75])
            rec.log(f"motion/{name}/predicted", band, static=True)

    def decide(self, rec: rr.RecordingStream, action: Action) -> None:
        """Log where the push that comes next should bring the object."""
        if (forecast := action.proposal.forecast) is None:
            return
        mean = forecast.mean
        around = rr.LineStrips2D.from_fields(strips=[self._px(ellipse(mean, forecast.cov))])
        rec.log("camera/forecast/centroid", around)
        reach = rotation(mean[2]) @ (AXIS_M, 0.0)
        heading = self._px(np.stack([mean[:2] - reach, mean[:2] + reach]))
        rec.log("camera/forecast/angle", rr.LineStrips2D.from_fields(strips=[heading]))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log the motion beside its forecast, and take away the drawing."""
        rec.log("camera/forecast", rr.Clear(recursive=True))
        before, now = self._before, actual(record)
        self._before = now
        forecast = None if record.action is None else record.action.proposal.forecast
        if forecast is None:
            for name in MOTION:
                rec.log(f"motion/{name}/actual", rr.Scalars(np.nan))
            return
        mean, cov = forecast.mean, forecast.cov
        step = mean[:2] - before[:2]
        along = step / max(float(np.linalg.norm(step)), 1e-9)
        spread = float(np.sqrt(along @ cov[:2, :2] @ along))
        moves = (
            (1e3, float((now[:2] - before[:2]) @ along), float(step @ along), spread),
            (180 / np.pi, now[2] - before[2], mean[2] - before[2], float(np.sqrt(cov[2, 2]))),
        )
        for name, (unit, came, expected, sigma) in zip(MOTION, moves, strict=True):
            rec.log(f"motion/{name}/actual", rr.Scalars(unit * came))
            band = unit * (expected + BAND * sigma * np.array([0.0, -1.0, 1.0]))
            rec.log(f"motion/{name}/predicted", rr.Scalars(band))
            self._legends.add(f"motion/{name}", record.k, [unit * came, *band])

    def _px(self, points: np.ndarray) -> np.ndarray:
        return self._camera.to_picture(points, self._width)


def ellipse(mean: np.ndarray, cov: np.ndarray, n: int = 48) -> np.ndarray:
    """Outline `(n + 1, 2)` of the centroid's ellipse at `BAND` standard deviations."""
    values, vectors = np.linalg.eigh(cov[:2, :2])
    angle = np.linspace(0, 2 * np.pi, n + 1)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    return np.asarray(mean[:2] + (BAND * vectors @ (np.sqrt(np.maximum(values, 0))[:, None] * circle)).T)
