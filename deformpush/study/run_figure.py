"""figures/run.png: the paper's Fig. 2 for one run, drawn from its folder alone."""

import io
from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.typing import RcKeyType

from deformpush.record import palette
from deformpush.record.folder import FIGURES, RunFolder
from deformpush.record.palette import unit
from deformpush.study import bottom_view_plot, run_data
from deformpush.study.run_data import RunData
from deformpush.task import TERMS, ErrorTerm

STYLE: dict[RcKeyType, Any] = {
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
"""What all figures of the project have in common."""
WIDTH, HEIGHT, DPI = 7.2, 4.3, 300
"""Inches across two columns of a printed page, and dots per inch."""
TOP: dict[str, float] = {"bottom": 0.565, "top": 0.955}
BELOW: dict[str, float] = {"left": 0.075, "bottom": 0.1, "top": 0.475}
TWO_AXES: dict[str, float] = {"right": 0.905, "wspace": 0.47}
"""Room for the axes of the actions, left and right of them."""
ONE_AXIS: dict[str, float] = {"right": 0.97, "wspace": 0.26}
MANY = 100
"""Beyond so many pushes their marks would cover one another, and stand below each other instead."""
FAST = 2
"""PNG compression: a fifth larger than at the usual 6, in a third of the time."""
PUSH = "push k"
SCALE_BAR_M = 0.1
DASHES = (0, (4, 3))


def draw(folder: RunFolder) -> None:
    """Write figures/run.png."""
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        made = figure(run_data.read(folder))
        made.savefig(buffer, format="png", dpi=DPI, pil_kwargs={"compress_level": FAST})
    folder.write(f"{FIGURES}/run.png", buffer.getvalue())


def figure(run: RunData) -> Figure:
    """Four bottom views, the errors, the actions with xi."""
    made = Figure(figsize=(WIDTH, HEIGHT))
    # Places as shares of the page: matplotlib's own layout would draw everything twice to find them.
    top = made.add_gridspec(1, 4, left=0.01, right=0.99, wspace=0.07, **TOP).subplots()
    many = run.last > MANY
    below = made.add_gridspec(1, 2, **BELOW, **(ONE_AXIS if many else TWO_AXES))
    left, right = below[0], below[1]
    views(list(np.ravel(np.asarray(top))), run)
    errors(made.add_subplot(left), run)
    if many:
        strips(list(np.ravel(np.asarray(right.subgridspec(3, 1, hspace=0.2).subplots(sharex=True)))), run)
    else:
        actions(made.add_subplot(right), run)
    return made


def views(axes: list[Axes], run: RunData) -> None:
    """Bottom views with goal (yellow), contour, and the next push as a red dot with its arrow."""
    square = bottom_view_plot.square_around(run, run.moments)
    for axis, k in zip(axes, run.moments, strict=True):
        bottom_view_plot.plot(axis, run, k)
        bottom_view_plot.show_square(axis, square)
        axis.set_title(f"k = {k}")
    middle, half = square
    x, y = middle - half + 0.06 * half
    axes[0].plot([x, x + SCALE_BAR_M], [y, y], color="black", linewidth=1.5, solid_capstyle="butt")
    axes[0].text(
        x + SCALE_BAR_M / 2, y + 0.03 * half, f"{SCALE_BAR_M * 1e3:.0f} mm", ha="center", va="bottom", size=6
    )


def errors(axis: Axes, run: RunData) -> None:
    """The errors (1)-(3) over k, each with its stop as a dashed line of its colour."""
    poses = run.poses
    for term, stop, level in zip(TERMS, poses.stops, poses.error_stops, strict=False):  # fewer in old runs
        colour = unit(term.colour)
        sizes = run.pushes[term.symbol].abs()
        axis.plot(run.pushes["k"], sizes, color=colour, label=f"{_symbol(term)}, stop {_shown(term, stop)}")
        axis.axhline(level, color=colour, linestyle=DASHES, linewidth=0.8)
    _frame(axis, run)
    axis.spines["right"].set_visible(False)
    axis.set(ylabel="error (-)", ylim=(0, None))
    axis.legend(loc="lower center", bbox_to_anchor=(0.5, 1.03), ncols=3, handlelength=1.2, columnspacing=1.2)


def actions(axis: Axes, run: RunData) -> None:
    """The actions kappa and d on two left axes, the change of error xi they made on the right axis."""
    rows = run.pushes.iloc[1:]
    change, distance = axis.twinx(), axis.twinx()
    change.bar(rows["k"], rows["xi"], width=0.8, color=unit(palette.XI), alpha=0.75)
    change.axhline(0, color=unit(palette.XI), linewidth=0.6)
    axis.plot(rows["k"], rows["kappa"], "o-", color=unit(palette.KAPPA), markersize=2.6, linewidth=0.6)
    distance.plot(rows["k"], rows["d"] * 1e3, "s-", color=unit(palette.D), markersize=2.4, linewidth=0.6)
    _frame(change, run)
    axis.set_xlabel(PUSH)
    (kappa_low, kappa_high), (d_low, d_high) = run.poses.outer_bounds
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


def strips(axes: list[Axes], run: RunData) -> None:
    """The same for many pushes: a panel each for kappa, d and xi, a dot for each push."""
    rows, (kappa, d, change) = run.pushes.iloc[1:], axes
    (kappa_low, kappa_high), (d_low, d_high) = run.poses.outer_bounds
    reach = 1.1 * float(rows["xi"].abs().max())
    for axis, values, text, colour, limits in (
        (kappa, rows["kappa"], r"$\kappa$ (-)", palette.KAPPA, _padded(kappa_low, kappa_high)),
        (d, rows["d"] * 1e3, "$d$ (mm)", palette.D, _padded(d_low * 1e3, d_high * 1e3)),
        (change, rows["xi"], r"$\xi$ (-)", palette.XI, (-reach, reach)),
    ):
        axis.plot(rows["k"], values, ".", color=unit(colour), markersize=2.5, markeredgewidth=0, alpha=0.7)
        axis.set_ylim(*limits)
        _label(axis, "left", text, colour)
        axis.spines["right"].set_visible(False)
        _shade(axis, run)
    change.axhline(0, color="0.4", linewidth=0.6)
    change.set(xlabel=PUSH, xlim=(0, run.last + 0.5))
    axes[0].figure.align_ylabels(axes)


def _symbol(term: ErrorTerm) -> str:
    """The symbol of what is drawn, the size of an error."""
    return f"$|{term.tex.strip('$')}|$" if term.signed else term.tex


def _shown(term: ErrorTerm, stop: float) -> str:
    """A stop value, given in SI units, with its unit."""
    return f"{stop * term.scale:.3g} {term.unit}".removesuffix(" -")


def _label(axis: Axes, side: Literal["left", "right"], text: str, colour: palette.Colour) -> None:
    """Label a y axis in the colour of its line, darkened so that it reads on paper."""
    axis.set_ylabel(text, color=tuple(0.75 * channel for channel in unit(colour)))
    axis.yaxis.set_label_position(side)
    axis.yaxis.set_ticks_position(side)


def _frame(axis: Axes, run: RunData) -> None:
    """Label the pushes and shade those of the initial design."""
    axis.set(xlabel=PUSH, xlim=(0, run.last + 0.5))
    _shade(axis, run)
    if run.initial:
        place = axis.get_xaxis_transform()
        axis.text(run.initial / 2, 1.01, "initial", transform=place, ha="center", size=6, color="0.4")


def _shade(axis: Axes, run: RunData) -> None:
    if run.initial:
        axis.axvspan(0, run.initial, color="0.93", linewidth=0, zorder=0)


def _padded(low: float, high: float) -> tuple[float, float]:
    pad = 0.04 * (high - low)
    return low - pad, high + pad
