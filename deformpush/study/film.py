"""The film of a run: its bottom view, and the errors growing with it."""

import io
from collections.abc import Iterator
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from deformpush.record import palette
from deformpush.record.finished import ERRORS, FinishedRun
from deformpush.record.palette import unit
from deformpush.study.run_figure import PUSH, STYLE, Run, around, view

WIDTH, HEIGHT, DPI = 1280, 720, 100
"""Pixels of a picture, and its dots per inch; even, as the encoder wants."""
RATE = 10
"""Pictures a second: more would only repeat what stands still."""
THICK = 2.2
"""Lines and marks against those on paper: the screen is looked at from farther away."""
LAST_S = 2.0
"""How long the end is shown."""


def write(path: Path, finished: FinishedRun, run: Run, seconds: float) -> float:
    """Write an MP4 (H.264) that shows every push for `seconds`; return how long it is (s)."""
    import av

    shown = 0
    with av.open(str(path), "w", options={"movflags": "faststart"}) as file:
        stream = file.add_stream("libx264", rate=RATE, options={"crf": "20", "preset": "medium"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for k, picture in enumerate(pictures(finished, run)):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            for _ in range(round(RATE * (LAST_S if k == run.last else seconds))):
                frame.pts = shown
                shown += 1
                file.mux(stream.encode(frame))
        file.mux(stream.encode(None))
    return shown / RATE


def pictures(finished: FinishedRun, run: Run) -> Iterator[np.ndarray]:
    """A picture `(HEIGHT, WIDTH, 3)` of the state after each push."""
    with matplotlib.rc_context(STYLE | {"font.size": 11, "axes.titlesize": 11, "legend.fontsize": 10}):
        room = ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1)
        figure = Figure(figsize=(WIDTH / DPI, HEIGHT / DPI), dpi=DPI, layout=room)
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=[1.05, 1.0])))
        look = left.subplots()
        panels = list(right.subplots(3, 1, sharex=True))
        lines = [_panel(axis, finished, run, i) for i, axis in enumerate(panels)]
        panels[-1].set_xlabel(PUSH)
        panels[-1].xaxis.get_major_locator().set_params(integer=True)
        right.align_ylabels(panels)
        middle, half = around(run, range(run.last + 1))
        for k in range(run.last + 1):
            look.clear()
            view(look, run, k, THICK)
            look.plot(*run.trace.centroids[: k + 1].T, color=unit(palette.TRAIL), linewidth=1.5)
            look.set(xlim=middle[0] + np.array([-half, half]), ylim=middle[1] + np.array([-half, half]))
            look.set_title(_said(finished, run, k), loc="left")
            for (curve, dot), error in zip(lines, ERRORS, strict=False):
                values = finished.error(error)[: k + 1]
                curve.set_data(range(k + 1), values)
                dot.set_data([k], values[-1:])
            buffer = io.BytesIO()
            figure.savefig(buffer, format="rgba", dpi=DPI)
            seen = np.frombuffer(buffer.getvalue(), np.uint8).reshape(HEIGHT, WIDTH, 4)
            yield np.ascontiguousarray(seen[..., :3])


def _panel(axis: Axes, finished: FinishedRun, run: Run, i: int) -> tuple[matplotlib.lines.Line2D, ...]:
    """One error, empty as yet: its line and the dot at its end."""
    error = ERRORS[i]
    colour, stop = unit(error.colour), finished.stop(error)
    (curve,) = axis.plot([], [], color=colour, linewidth=2)
    (dot,) = axis.plot([], [], "o", color=colour, markersize=6)
    if np.isfinite(stop):
        axis.axhline(stop, color=unit(palette.STOP), linestyle=(0, (4, 3)), linewidth=1)
        text = f"stop {stop:.3g}"
        axis.annotate(
            text, (run.last, stop), xytext=(0, 3), textcoords="offset points", ha="right", color="0.4"
        )
    if run.initial:
        axis.axvspan(0, min(run.initial, run.last), color="0.93", linewidth=0, zorder=0)
    top = 1.1 * max(finished.error(error).max(), stop if np.isfinite(stop) else 0.0)
    axis.set(xlim=(0, max(run.last, 1)), ylim=(0, top or 1.0), ylabel=error.label)
    axis.spines["right"].set_visible(False)
    return curve, dot


def _said(finished: FinishedRun, run: Run, k: int) -> str:
    """Which push this is, and which comes next."""
    if k == run.last:
        return f"{finished.title}\nafter push {k}: {finished.summary.status}"
    u = finished.pushes.iloc[k + 1]
    following = f"next, {u['phase']}: kappa {u['kappa']:.2f}, d {1e3 * u['d']:.0f} mm"
    return f"{finished.title}\nafter push {k}; {following}"
