"""The film of a run: its bottom view, and the errors growing with it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.typing import RcKeyType

from deformpush.record import palette
from deformpush.record.finished import FinishedRun
from deformpush.record.palette import unit
from deformpush.record.settings import RECENT
from deformpush.study.bottom_view_plot import plot, show_square, square_around
from deformpush.study.run_data import RunData
from deformpush.study.run_figure import DASHES, PUSH, STYLE
from deformpush.task import TERMS, ErrorTerm

Array = np.ndarray

WIDTH, HEIGHT, DPI = 1280, 720, 100
"""Pixels of a picture, and its dots per inch; even, as the encoder wants."""
LARGER: dict[RcKeyType, Any] = {"font.size": 11, "axes.titlesize": 11, "legend.fontsize": 10}
RATE = 10
"""Pictures a second: more would only repeat what stands still."""
CODING = {"crf": "20", "preset": "medium", "rc-lookahead": "10"}
"""Of libx264. To look 40 pictures ahead, as it does by itself, takes 100 MB more and saves nothing here."""
THICK = 2.2
"""Lines and marks against those on paper: the screen is looked at from farther away."""
LAST_S = 2.0
"""How long the end is shown."""


def write(path: Path, finished: FinishedRun, run: RunData, seconds: float) -> float:
    """Write an MP4 (H.264) that shows every push for `seconds`; return how long it is (s)."""
    import av

    shown = 0
    with av.open(str(path), "w", options={"movflags": "faststart"}) as file:
        stream = file.add_stream("libx264", rate=RATE, options=CODING)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for k, picture in enumerate(pictures(finished, run)):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            for _ in range(round(RATE * (LAST_S if k == run.last else seconds))):
                frame.pts = shown
                shown += 1
                file.mux(stream.encode(frame))
        file.mux(stream.encode(None))
    return shown / RATE


def pictures(finished: FinishedRun, run: RunData) -> Iterator[Array]:
    """A picture `(HEIGHT, WIDTH, 3)` of the state after each push."""
    with matplotlib.rc_context(STYLE | LARGER):
        frame = Frame(finished, run)
        for k in range(run.last + 1):
            frame.show(k)
            yield frame.picture()


class Frame:
    """The figure that every picture of the film is taken of."""

    def __init__(self, finished: FinishedRun, run: RunData) -> None:
        """Lay it out; its curves are empty until `show`."""
        self._finished, self._run = finished, run
        room = ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1)
        self.figure = Figure(figsize=(WIDTH / DPI, HEIGHT / DPI), dpi=DPI, layout=room)
        self._canvas = FigureCanvasAgg(self.figure)  # draws once what `savefig` draws twice
        self._still: Any = None
        left, right = np.ravel(np.asarray(self.figure.subfigures(1, 2, width_ratios=[1.05, 1.0])))
        self.view: Axes = left.subplots()
        self.panels: list[Axes] = list(right.subplots(len(TERMS), 1, sharex=True))
        self._curves = [self._panel(axis, term) for axis, term in zip(self.panels, TERMS, strict=True)]
        self.panels[-1].set_xlabel(PUSH)
        self.panels[-1].xaxis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 2.5, 5, 10], integer=True))
        right.align_ylabels(self.panels)
        self._square = square_around(run, range(run.last + 1))
        self._moving: list[Artist] = [self.view, *(line for curve in self._curves for line in curve)]
        for artist in self._moving:
            artist.set_animated(True)

    def show(self, k: int) -> None:
        """Draw the state after push k."""
        run, view = self._run, self.view
        view.clear()
        plot(view, run, k, THICK)
        view.plot(
            *run.poses.centroids[max(0, k - RECENT) : k + 1].T, color=unit(palette.TRAIL), linewidth=1.5
        )
        show_square(view, self._square)
        view.set_title(self._title(k), loc="left")
        for (curve, dot), term in zip(self._curves, TERMS, strict=True):
            values = self._finished.error(term)[: k + 1]
            curve.set_data(range(k + 1), values)
            dot.set_data([k], values[-1:])

    def picture(self) -> Array:
        """What the figure shows now, `(HEIGHT, WIDTH, 3)`.

        Places are found once, and what stands still (axes and their texts) is drawn once: for each picture
        that would take three times as long as what moves.
        """
        canvas: Any = self._canvas
        if self._still is None:
            canvas.draw()
            self.figure.set_layout_engine("none")
            self._still = canvas.copy_from_bbox(self.figure.bbox)
        canvas.restore_region(self._still)
        for artist in self._moving:
            artist.draw(canvas.get_renderer())
        seen = np.asarray(self._canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        return np.ascontiguousarray(seen[..., :3])

    def _panel(self, axis: Axes, term: ErrorTerm) -> tuple[Line2D, Line2D]:
        """One error, empty as yet: its line and the dot at its end."""
        run, colour, stop = self._run, unit(term.colour), self._finished.stop(term)
        (curve,) = axis.plot([], [], color=colour, linewidth=2)
        (dot,) = axis.plot([], [], "o", color=colour, markersize=6)
        if np.isfinite(stop):
            axis.axhline(stop, color=unit(palette.STOP), linestyle=DASHES, linewidth=1)
            text, at = f"stop {stop:.3g}", (run.last, stop)
            axis.annotate(text, at, xytext=(0, 3), textcoords="offset points", ha="right", color="0.4")
        if run.initial:
            axis.axvspan(0, min(run.initial, run.last), color="0.93", linewidth=0, zorder=0)
        top = 1.1 * np.nanmax([*self._finished.error(term), stop, 0.0])
        axis.set(xlim=(0, max(run.last, 1)), ylim=(0, top or 1.0), ylabel=term.label)
        axis.spines["right"].set_visible(False)
        return curve, dot

    def _title(self, k: int) -> str:
        """What is seen, which push this is after, and which comes next."""
        if k == self._run.last:
            return f"{self._finished.title}\nafter push {k}: {self._finished.summary.status}"
        u = self._run.pushes.iloc[k + 1]
        following = f"next, {u['phase']}: kappa {u['kappa']:.2f}, d {1e3 * u['d']:.0f} mm"
        return f"{self._finished.title}\nafter push {k}; {following}"
