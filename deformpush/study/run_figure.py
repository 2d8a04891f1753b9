"""figures/run.png: the paper's Fig. 2 for one run, drawn from its folder alone."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrow, Polygon

from deformpush.record import palette, table
from deformpush.record.folder import FIGURES, RunFolder
from deformpush.record.palette import unit
from deformpush.record.poses import Trace, read_trace, read_views

if TYPE_CHECKING:
    import pandas as pd

STYLE: dict[Any, Any] = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 7,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}
WIDTH, HEIGHT, DPI = 7.2, 4.3, 300
"""Inches across two columns of a printed page, and dots per inch."""
TOP: dict[str, Any] = {"bottom": 0.565, "top": 0.955}
BELOW: dict[str, Any] = {"bottom": 0.1, "top": 0.475}
FAST = 2
"""PNG compression: a fifth larger than at the usual 6, in a third of the time."""
PUSH = "push k"
SCALE_BAR_M = 0.1
CLEAR = (20.0, 70.0)
"""How far from white the darkest channel of a pixel is that just shows, and of one that is opaque: what JPEG
leaves around the object shows nowhere."""


@dataclass(frozen=True)
class Run:
    """What the figures need of a run folder."""

    pushes: "pd.DataFrame"
    trace: Trace
    pictures: list[np.ndarray]

    @property
    def last(self) -> int:
        """The last k that table, contours and pictures all have."""
        return min(len(self.pushes), len(self.trace.contours), len(self.pictures)) - 1

    @property
    def initial(self) -> int:
        """Pushes of the initial design, S0 or as many as were made."""
        return int((self.pushes["phase"] == "initial").sum())

    @property
    def moments(self) -> list[int]:
        """Four k worth a picture: 0, S0, half-way from there, the last; in a short run evenly spaced ones."""
        if self.last <= self.initial:
            return [round(self.last * share / 3) for share in range(4)]
        return [0, self.initial, (self.initial + self.last) // 2, self.last]


def load(folder: RunFolder) -> Run:
    """Read a run folder, also one of a run that was killed.

    Raises:
        OSError, ValueError: a file is missing or damaged.
    """
    return Run(table.read(folder.table), read_trace(folder.contours), read_views(folder.views))


def draw(folder: RunFolder) -> None:
    """Write figures/run.png: four bottom views, the errors, the actions with xi."""
    run = load(folder)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, HEIGHT))
        # Places as shares of the page: matplotlib's own layout would draw everything twice to find them.
        top = figure.add_gridspec(1, 4, left=0.01, right=0.99, wspace=0.07, **TOP).subplots()
        below = figure.add_gridspec(1, 2, left=0.075, right=0.905, wspace=0.47, **BELOW).subplots()
        views(list(np.ravel(np.asarray(top))), run)
        left, right = np.ravel(np.asarray(below))
        errors(left, run)
        actions(right, run)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=DPI, pil_kwargs={"compress_level": FAST})
    folder.write(f"{FIGURES}/run.png", buffer.getvalue())


def views(axes: list[Axes], run: Run) -> None:
    """Bottom views with goal (yellow), contour, and the next push as a red dot with its arrow."""
    middle, half = around(run, run.moments)
    for axis, k in zip(axes, run.moments, strict=True):
        view(axis, run, k)
        axis.set(xlim=middle[0] + np.array([-half, half]), ylim=middle[1] + np.array([-half, half]))
        axis.set_title(f"k = {k}")
    x, y = middle - half + 0.06 * half
    axes[0].plot([x, x + SCALE_BAR_M], [y, y], color="black", linewidth=1.5, solid_capstyle="butt")
    axes[0].text(
        x + SCALE_BAR_M / 2, y + 0.03 * half, f"{SCALE_BAR_M * 1e3:.0f} mm", ha="center", va="bottom", size=6
    )


def around(run: Run, moments: Sequence[int]) -> tuple[np.ndarray, float]:
    """Middle `(2,)` and half side (m) of the square that shows goal, pushes and the object at these k."""
    trace = run.trace
    seen = np.concatenate([trace.goal_outline, *(trace.contours[k] for k in moments), trace.starts[1:]])
    low, high = np.nanmin(seen, 0), np.nanmax(seen, 0)
    return (low + high) / 2, float(np.max(high - low) / 2 + 0.02)


def view(axis: Axes, run: Run, k: int, thick: float = 1.0) -> None:
    """The bottom view after push k, with the next push; lines are `thick` times as thick as on paper."""
    trace, camera = run.trace, run.trace.camera
    low, high = camera.to_m(np.array([[-0.5, camera.pixels - 0.5], [camera.pixels - 0.5, -0.5]]))
    goal = unit(palette.GOAL)
    axis.add_patch(Polygon(trace.goal_outline, facecolor=unit(palette.lighter(palette.GOAL, 0.6)), zorder=0))
    place = (low[0], high[0], low[1], high[1])
    axis.imshow(_seen_through(run.pictures[k]), extent=place, interpolation="bicubic", zorder=1)
    axis.add_patch(Polygon(trace.goal_outline, facecolor="none", edgecolor=goal, linewidth=1.2 * thick))
    outline = unit(palette.CONTOUR)
    axis.add_patch(Polygon(trace.contours[k], facecolor="none", edgecolor=outline, linewidth=0.9 * thick))
    if k < run.last:
        _next_push(axis, trace.starts[k + 1], trace.ends[k + 1], thick)
    axis.set(xticks=[], yticks=[])
    axis.spines[:].set_visible(True)
    axis.spines[:].set_color("0.6")


def errors(axis: Axes, run: Run) -> None:
    """The errors (1)-(3) over k, each with its stop as a dashed line of its colour."""
    k = run.pushes["k"]
    position, angle, shape = run.trace.stops
    for name, stop, colour, text in (
        ("e_c", run.trace.error_stops[0], palette.E_C, f"$e_c$, stop {position * 1e3:.3g} mm"),
        (
            "e_theta",
            run.trace.error_stops[1],
            palette.E_THETA,
            rf"$|e_\theta|$, stop {np.degrees(angle):.3g}°",
        ),
        ("e_gamma", run.trace.error_stops[2], palette.E_GAMMA, rf"$e_\gamma$, stop {shape:.3g}"),
    ):
        axis.plot(k, run.pushes[name].abs(), color=unit(colour), label=text)
        axis.axhline(stop, color=unit(colour), linestyle=(0, (4, 3)), linewidth=0.8)
    _frame(axis, run)
    axis.spines["right"].set_visible(False)
    axis.set(ylabel="error (-)", ylim=(0, None))
    axis.legend(loc="lower center", bbox_to_anchor=(0.5, 1.03), ncols=3, handlelength=1.2, columnspacing=1.2)


def actions(axis: Axes, run: Run) -> None:
    """The actions kappa and d on two left axes, the change of error xi they made on the right axis."""
    rows = run.pushes.iloc[1:]
    change, distance = axis.twinx(), axis.twinx()
    change.bar(rows["k"], rows["xi"], width=0.8, color=unit(palette.XI), alpha=0.75)
    change.axhline(0, color=unit(palette.XI), linewidth=0.6)
    axis.plot(rows["k"], rows["kappa"], "o-", color=unit(palette.KAPPA), markersize=2.6, linewidth=0.6)
    distance.plot(rows["k"], rows["d"] * 1e3, "s-", color=unit(palette.D), markersize=2.4, linewidth=0.6)
    _frame(change, run)
    axis.set_xlabel(PUSH)
    (kappa_low, kappa_high), (d_low, d_high) = run.trace.outer_bounds
    axis.set_ylim(*_padded(kappa_low, kappa_high))
    distance.set_ylim(*_padded(d_low * 1e3, d_high * 1e3))
    reach = 1.1 * float(rows["xi"].abs().max()) if len(rows) else 1.0
    change.set_ylim(-reach, reach)
    _label(axis, "left", r"contour ratio $\kappa$ (-)", palette.KAPPA)
    _label(distance, "left", "distance $d$ (mm)", palette.D)
    _label(change, "right", r"change of error $\xi$ (-)", palette.XI)
    distance.spines["left"].set_position(("outward", 36))
    distance.spines["left"].set_visible(True)
    for other in (axis, distance):
        other.grid(False)
    change.spines["right"].set_visible(True)
    axis.set_zorder(change.get_zorder() + 1)
    axis.patch.set_visible(False)
    distance.set_zorder(axis.get_zorder() + 1)


def _label(axis: Axes, side: Literal["left", "right"], text: str, colour: palette.Colour) -> None:
    """Label a y axis in the colour of its line, darkened so that it reads on paper."""
    axis.set_ylabel(text, color=tuple(0.75 * channel for channel in unit(colour)))
    axis.yaxis.set_label_position(side)
    axis.yaxis.set_ticks_position(side)


def _seen_through(picture: np.ndarray) -> np.ndarray:
    """The picture `(H, W, 4)` with its white ground taken away, so that the goal can lie below the object."""
    begins, opaque = CLEAR
    alpha = np.clip((255.0 - picture.min(-1) - begins) / (opaque - begins), 0, 1) * 255
    return np.dstack([picture, alpha.astype(np.uint8)])


def _next_push(axis: Axes, start: np.ndarray, end: np.ndarray, thick: float) -> None:
    red = unit(palette.NEXT_PUSH)
    step = end - start
    width = 0.004
    axis.add_patch(
        FancyArrow(
            *start,
            *step,
            width=width,
            head_width=4 * width,
            length_includes_head=True,
            color=red,
            linewidth=0,
        )
    )
    axis.plot(*start, "o", color=red, markersize=3.5 * thick)


def _frame(axis: Axes, run: Run) -> None:
    """Label the pushes and shade those of the initial design."""
    axis.set(xlabel=PUSH, xlim=(0, run.last + 0.5))
    if run.initial:
        axis.axvspan(0, run.initial, color="0.93", linewidth=0, zorder=0)
        axis.text(
            run.initial / 2,
            1.01,
            "initial",
            transform=axis.get_xaxis_transform(),
            ha="center",
            size=6,
            color="0.4",
        )


def _padded(low: float, high: float) -> tuple[float, float]:
    pad = 0.04 * (high - low)
    return low - pad, high + pad
