"""Entities `errors/*`, `strain`, `actions/*`, `xi/*`, `phase`: numbers over k, as in pushes.csv."""

import numpy as np
import rerun as rr

from deformpush.push_record import Decision, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.record.palette import Colour, lighter
from deformpush.viewer.legends import Corners

BAND = 2.0
"""The band of the predicted xi reaches this many sigma to both sides."""
PREDICTED = f"predicted, {BAND:.0f} sigma"
"""Lines of one name and colour share one entry of the legend, which hides less of the plot."""


class Series:
    """Errors with their stops, actions inside their bounds, xi as predicted and as it came.

    What people read is in millimetres and degrees. Lines that belong together share one entity.
    """

    def __init__(self, corners: Corners) -> None:
        """`corners` is told what is drawn where."""
        self._corners = corners

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log names and colours."""
        self._stops = (info.stop_position_m * 1e3, np.degrees(info.stop_angle_rad), info.stop_e_gamma)
        for name, title, colour in (
            ("position", "position (mm)", palette.E_C),
            ("angle", "angle (deg)", palette.E_THETA),
            ("shape", "shape e_gamma (-)", palette.E_GAMMA),
        ):
            _lines(rec, f"errors/{name}", [title, "stop"], [colour, palette.STOP], [2.0, 1.0])
        _lines(rec, "errors/total", ["e_T (-)"], [palette.E_T], [2.0])
        self._limit = info.strain_limit
        self._strain = first.after.strain is not None
        if self._strain:
            names, colours = ["peak strain (%)", "at rest"], [palette.PEAK, lighter(palette.PEAK)]
            limit = [] if self._limit is None else ["limit"]
            _lines(rec, "strain", [*names, *limit], [*colours, palette.STOP], [2.0, 1.0, 1.0])
        for name, title, colour in (("kappa", "kappa (-)", palette.KAPPA), ("d", "d (mm)", palette.D)):
            _dots(rec, f"actions/{name}", title, colour)
            bound = lighter(colour, 0.3)
            _lines(rec, f"actions/{name}/bounds", ["bounds"] * 2, [bound] * 2, [1.0] * 2)
        _dots(rec, "xi/actual", "xi (-)", palette.XI)
        _lines(rec, "xi/predicted", [PREDICTED] * 3, [palette.BOUND] * 3, [1.5, 0.75, 0.75])
        phases = list(palette.PHASES)
        colours = [palette.PHASES[name] for name in phases]
        rec.log("phase", rr.StateConfiguration(values=phases, labels=phases, colors=colours), static=True)

    def decide(self, rec: rr.RecordingStream, decision: Decision) -> None:
        """Log the phase: push k fills the time from k - 1 to k."""
        rec.log("phase", rr.StateChange(state=decision.phase))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log one row of numbers."""
        errors = (record.position_error_m * 1e3, abs(np.degrees(record.angle_error_rad)), record.e_gamma)
        for name, error, stop in zip(("position", "angle", "shape"), errors, self._stops, strict=True):
            self._draw(rec, record.k, f"errors/{name}", [error, stop])
        rec.log("errors/total", rr.Scalars(record.e_T))
        if self._strain:
            told = record.strain
            strain = [np.nan, np.nan] if told is None else [told.p99_peak, told.residual]
            limit = [] if self._limit is None else [self._limit]
            self._draw(rec, record.k, "strain", [100 * value for value in strain + limit])
        if (u := record.decision) is None:
            for path in ("actions/kappa", "actions/d", "xi/actual"):
                rec.log(path, rr.Scalars(np.nan))  # so that all plots begin at k = 0
            return
        self._draw(rec, record.k, "actions/kappa", [u.kappa])
        self._draw(rec, record.k, "actions/d", [u.d * 1e3])
        self._draw(rec, record.k, "actions/kappa", u.bounds[0].tolist(), "/bounds")
        self._draw(rec, record.k, "actions/d", (u.bounds[1] * 1e3).tolist(), "/bounds")
        self._draw(rec, record.k, "xi", [record.xi], "/actual")
        if np.isfinite(u.xi_mean):
            reach = BAND * u.xi_std
            band = [u.xi_mean, u.xi_mean - reach, u.xi_mean + reach]
            self._draw(rec, record.k, "xi", band, "/predicted")

    def _draw(
        self, rec: rr.RecordingStream, k: int, strip: str, values: list[float], below: str = ""
    ) -> None:
        """Log values of one entity of a strip, `below` it."""
        rec.log(strip + below, rr.Scalars(values))
        self._corners.add(strip, k, values, below)


def _lines(
    rec: rr.RecordingStream, path: str, names: list[str], colours: list[Colour], widths: list[float]
) -> None:
    rec.log(path, rr.SeriesLines(names=names, colors=colours, widths=widths), static=True)


def _dots(rec: rr.RecordingStream, path: str, name: str, colour: Colour) -> None:
    _lines(rec, path, [name], [colour], [1.0])
    rec.log(path, rr.SeriesPoints(names=name, colors=colour, markers="circle", marker_sizes=3.0), static=True)
