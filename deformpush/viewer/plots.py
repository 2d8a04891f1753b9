"""Entities `errors/*`, `strain`, `force`, `actions/*`, `xi/*`, `phase`: numbers over k, as in pushes.csv."""

import numpy as np
import rerun as rr

from deformpush.cell.world import Outcome
from deformpush.push_record import Action, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.record.palette import Colour, lighter
from deformpush.task import TERMS, TOTAL
from deformpush.viewer.legends import Legends
from deformpush.viewer.panel import Panel

BAND = 2.0
"""The band of the predicted xi reaches this many sigma to both sides."""
PREDICTED = f"predicted, {BAND:.0f} sigma"
"""Lines of one name and colour share one entry of the legend, which hides less of the plot."""


class Plots(Panel):
    """Errors with their stops, actions inside their bounds, xi as predicted and as it came.

    What people read is in millimetres and degrees. Lines that belong together share one entity.
    """

    def __init__(self, legends: Legends) -> None:
        """`legends` is told what is drawn where."""
        self._legends = legends

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log names and colours."""
        self._stops = {term.name: info.stop.value(term) * term.scale for term in TERMS}
        for term in TERMS:
            names, colours = [f"{term.name} ({term.unit})", "stop"], [term.colour, palette.STOP]
            _lines(rec, f"errors/{term.name}", names, colours, [2.0, 1.0])
        _lines(rec, f"errors/{TOTAL.name}", [f"{TOTAL.symbol} ({TOTAL.unit})"], [TOTAL.colour], [2.0])
        self._limit = [] if info.strain_limit is None else [info.strain_limit]
        self._strain = first.view.strain is not None
        if self._strain:
            _peaks(rec, "strain", ["peak strain (%)", "at rest"], self._limit)
        self._force = "force" in info.offers
        self._force_limit = [] if info.force_limit is None else [info.force_limit]
        if self._force:
            _peaks(rec, "force", ["peak force (N)", "mean"], self._force_limit)
        for name, title, colour in (("kappa", "kappa (-)", palette.KAPPA), ("d", "d (mm)", palette.D)):
            _dots(rec, f"actions/{name}", title, colour)
            bound = lighter(colour, 0.3)
            _lines(rec, f"actions/{name}/bounds", ["bounds"] * 2, [bound] * 2, [1.0] * 2)
        _dots(rec, "xi/actual", "xi (-)", palette.XI)
        _lines(rec, "xi/predicted", [PREDICTED] * 3, [palette.BOUND] * 3, [1.5, 0.75, 0.75])
        phases = list(palette.PHASES)
        colours = [palette.PHASES[name] for name in phases]
        rec.log("phase", rr.StateConfiguration(values=phases, labels=phases, colors=colours), static=True)

    def decide(self, rec: rr.RecordingStream, action: Action) -> None:
        """Log the phase: push k fills the time from k - 1 to k."""
        rec.log("phase", rr.StateChange(state=action.proposal.phase))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log one row of numbers."""
        k, action = record.k, record.action
        for term in TERMS:
            error = record.errors.size(term)
            self._draw(rec, k, f"errors/{term.name}", [error, self._stops[term.name]])
        rec.log(f"errors/{TOTAL.name}", rr.Scalars(record.errors.size(TOTAL)))
        if self._strain:
            told = None if action is None else action.outcome.strain
            strain = [np.nan, np.nan] if told is None else [told.p99_peak, told.residual]
            self._draw(rec, k, "strain", [100 * value for value in strain + self._limit])
        if self._force:
            outcome = Outcome() if action is None else action.outcome
            force = [outcome.tool_force_peak, outcome.tool_force_mean, *self._force_limit]
            self._draw(rec, k, "force", [np.nan if value is None else value for value in force])
        if action is None:
            for path in ("actions/kappa", "actions/d", "xi/actual"):
                rec.log(path, rr.Scalars(np.nan))  # so that all plots begin at k = 0
            return
        made = action.proposal
        for name, value, bounds, scale in zip(("kappa", "d"), action.u, made.bounds, (1.0, 1e3), strict=True):
            self._draw(rec, k, f"actions/{name}", [value * scale])
            self._draw(rec, k, f"actions/{name}", (bounds * scale).tolist(), "/bounds")
        self._draw(rec, k, "xi", [action.xi], "/actual")
        if np.isfinite(made.mean):
            reach = BAND * made.std
            self._draw(rec, k, "xi", [made.mean, made.mean - reach, made.mean + reach], "/predicted")

    def _draw(
        self, rec: rr.RecordingStream, k: int, strip: str, values: list[float], below: str = ""
    ) -> None:
        """Log values of one entity of a strip, `below` it."""
        rec.log(strip + below, rr.Scalars(values))
        self._legends.add(strip, k, values, below)


def _lines(
    rec: rr.RecordingStream, path: str, names: list[str], colours: list[Colour], widths: list[float]
) -> None:
    rec.log(path, rr.SeriesLines(names=names, colors=colours, widths=widths), static=True)


def _peaks(rec: rr.RecordingStream, path: str, names: list[str], limit: list[float]) -> None:
    """What a push did to the object: its peak, what is told beside it, and its limit, if it has one."""
    colours = [palette.PEAK, lighter(palette.PEAK), palette.STOP]
    _lines(rec, path, names + ["limit"] * len(limit), colours, [2.0, 1.0, 1.0])


def _dots(rec: rr.RecordingStream, path: str, name: str, colour: Colour) -> None:
    _lines(rec, path, [name], [colour], [1.0])
    rec.log(path, rr.SeriesPoints(names=name, colors=colour, markers="circle", marker_sizes=3.0), static=True)
