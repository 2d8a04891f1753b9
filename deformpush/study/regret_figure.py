"""Figure regret.png: what a run's pushes gained beside others from the same states, and what was foreseen."""

import io

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from deformpush.record import palette
from deformpush.record.forecasts import INSIDE
from deformpush.record.palette import unit
from deformpush.record.regret_table import Columns
from deformpush.study.run_figure import DASHES, DPI, PUSH, STYLE, WIDTH

FILE = "regret.png"
HEIGHT = 7.0
FURTHEST = 8.0
"""Standardised errors are drawn up to here at most."""
OTHERS, MADE, BEST, TRIED, MODEL = (
    palette.BOUND, palette.XI, palette.FORECAST, palette.D, palette.OBJECT,
)  # fmt: skip
Array = np.ndarray
Numbers = dict[str, Array]
"""Columns by name."""


def draw(rows: Columns, trials: Columns) -> bytes:
    """The figure as a PNG."""
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure(rows, trials).savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def figure(rows: Columns, trials: Columns) -> Figure:
    """Outcomes, regret, its sum; forecast against outcome, how many inside their intervals, how far off."""
    made = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    axes = list(made.subplots(3, 2).flat)
    run = {name: np.array(values) for name, values in rows.items()}
    tried = {name: np.array(values) for name, values in trials.items()}
    last = int(run["k"][-1])
    by_push = [axes[0], axes[1], axes[2], axes[4], axes[5]]
    for axis in by_push:
        axis.set(xlabel=PUSH, xlim=(0.3, last + 0.7))
        axis.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=8))
        _shade(axis, run)
    outcomes(axes[0], run, tried)
    regret(axes[1], run)
    cumulative(axes[2], run)
    forecasts(axes[3], tried, last)
    inside(axes[4], run)
    errors(axes[5], run, tried)
    for axis, letter in zip(axes, "abcdef", strict=True):
        axis.spines["right"].set_visible(False)
        axis.set_title(f"({letter}) {axis.get_title('left')}", loc="left", pad=15)
    return made


def outcomes(axis: Axes, run: Numbers, tried: Numbers) -> None:
    """What every push did: the one made, the best, and the others."""
    size = _size(run)
    axis.axhline(0, color="0.4", linewidth=0.6)
    axis.plot(tried["k"], tried["xi"], ".", color=unit(OTHERS), markersize=0.7 * size, markeredgewidth=0,
              alpha=0.7, label="tried")  # fmt: skip
    axis.plot(run["k"], run["xi_best"], "_", color=unit(BEST), markersize=1.7 * size, markeredgewidth=1.6,
              label="best")  # fmt: skip
    axis.plot(run["k"], run["xi"], "o", color=unit(MADE), markersize=0.9 * size, markeredgewidth=0,
              label="made")  # fmt: skip
    axis.set_ylabel(r"change of error $\xi$ (-)")
    axis.set_title("pushes tried from each state, and the one made", loc="left")
    _legend(axis)


def regret(axis: Axes, run: Numbers) -> None:
    """The regret of each push, of those tried on average, and of what the model's mean calls best."""
    axis.bar(run["k"], run["regret"], width=0.8, color=unit(MADE), label="made")
    axis.plot(run["k"], _of_tried(run), "_", color=unit(TRIED), markersize=1.6 * _size(run),
              markeredgewidth=1.4, label="mean of those tried")  # fmt: skip
    if np.isfinite(run["inference_regret"]).any():
        axis.plot(run["k"], run["inference_regret"], "D", color=unit(MODEL), markersize=0.6 * _size(run),
                  markeredgewidth=0, label="best by forecast")  # fmt: skip
    axis.set(ylabel=r"regret $r_k=\xi_k-\min\,\xi$ (-)", ylim=(0, None))
    axis.set_title("regret: what the best push gains more", loc="left")
    _legend(axis)


def cumulative(axis: Axes, run: Numbers) -> None:
    """Sums of regret: of the pushes made, and of those tried, on average."""
    k = np.append(0, run["k"])
    for values, colour, name in (
        (run["regret"], MADE, "made"),
        (_of_tried(run), TRIED, "mean of those tried"),
    ):
        total = np.append(0.0, np.cumsum(values))
        axis.plot(k, total, color=unit(colour), label=name)
        axis.annotate(f"{total[-1]:.3g}", (k[-1], total[-1]), xytext=(-2, 3), textcoords="offset points",
                      ha="right", size=7, color=_dark(colour))  # fmt: skip
    axis.set(ylabel=r"sum of regret $R_k$ (-)", ylim=(0, None), xlim=(0, k[-1] + 0.7))
    axis.margins(y=0.12)
    axis.set_title("cumulative regret", loc="left")
    _legend(axis)


def forecasts(axis: Axes, tried: Numbers, last: int) -> None:
    """Every forecast of the model against what came of it."""
    known = np.isfinite(tried["xi"]) & np.isfinite(tried["xi_mean"])
    axis.set(xlabel=r"forecast of $\xi$: mean (-)", ylabel=r"outcome $\xi$ (-)")
    axis.set_title("forecasts and outcomes of all pushes tried", loc="left")
    if not known.any():
        _without(axis)
        return
    mean, xi, k = (tried[name][known] for name in ("xi_mean", "xi", "k"))
    colours = LinearSegmentedColormap.from_list("k", [unit(one) for one in palette.ALONG])
    low, high = min(mean.min(), xi.min()), max(mean.max(), xi.max())
    axis.plot([low, high], [low, high], color="0.4", linewidth=0.8, linestyle=DASHES)
    dots = axis.scatter(mean, xi, c=k, s=5, cmap=colours, vmin=1, vmax=max(2, last), linewidths=0, alpha=0.7)
    bar = axis.figure.colorbar(dots, ax=axis, label=PUSH, pad=0.02, aspect=30)
    bar.outline.set_visible(False)
    bar.ax.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))


def inside(axis: Axes, run: Numbers) -> None:
    """Share of outcomes inside the model's intervals of 95 %, by push."""
    axis.set(ylabel="inside (%)", ylim=(0, 104))
    axis.set_title("outcomes inside their 95 % intervals", loc="left")
    if not np.isfinite(run["inside_95"]).any():
        _without(axis)
        return
    axis.axhline(95, color="0.4", linewidth=0.8, linestyle=DASHES)
    axis.plot(run["k"], 100 * run["inside_95"], "o-", color=unit(MODEL), markersize=0.8 * _size(run),
              markeredgewidth=0, linewidth=0.8)  # fmt: skip


def errors(axis: Axes, run: Numbers, tried: Numbers) -> None:
    """Standardised errors of the forecasts by push: their middle 95 %, middle half and median."""
    axis.set(ylabel=r"$z=(\xi-$mean$)\,/\,$std (-)")
    axis.set_title("errors of forecasts in units of their std", loc="left")
    z = (tried["xi"] - tried["xi_mean"]) / tried["xi_std"]
    parts = [z[(tried["k"] == k) & np.isfinite(z)] for k in run["k"]]
    known = np.array([len(part) > 0 for part in parts])
    if not known.any():
        _without(axis)
        return
    spread = np.array([np.percentile(part, (2.5, 25, 50, 75, 97.5)) for part in parts if len(part)]).T
    k, size = run["k"][known], _size(run)
    axis.axhspan(-INSIDE, INSIDE, color=unit(palette.lighter(MODEL, 0.85)), linewidth=0, zorder=0)
    axis.axhline(0, color="0.4", linewidth=0.6)
    axis.vlines(k, spread[0], spread[4], color=unit(MODEL), linewidth=0.9, label="95 % of pushes")
    axis.vlines(
        k, spread[1], spread[3], color=unit(MODEL), linewidth=0.7 * size, alpha=0.5, label="half of them"
    )
    axis.plot(k, spread[2], "o", color=unit(MODEL), markersize=0.7 * size, markeredgewidth=0, label="median")
    reach = min(FURTHEST, max(3.0, 1.05 * float(np.abs(spread).max())))
    axis.set_ylim(-reach, reach)
    _legend(axis)


def _of_tried(run: Numbers) -> Array:
    """Regret of the pushes tried, on average; 0 where none could be tried."""
    return np.nan_to_num(run["xi_tried"] - run["xi_best"])


def _size(run: Numbers) -> float:
    """Size of a mark (points), smaller where there are many pushes."""
    return float(np.clip(150.0 / len(run["k"]), 2.5, 5.5))


def _legend(axis: Axes) -> None:
    """Name the marks between title and axes, where they cover nothing."""
    axis.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.995), ncols=3, handlelength=1.0,
                handletextpad=0.4, columnspacing=1.2, borderpad=0.1, borderaxespad=0.1)  # fmt: skip


def _without(axis: Axes) -> None:
    axis.text(0.5, 0.5, "the optimizer has no model\nof all pushes", transform=axis.transAxes, ha="center",
              va="center", color="0.4")  # fmt: skip


def _dark(colour: palette.Colour) -> tuple[float, ...]:
    return tuple(0.75 * channel for channel in unit(colour))


def _shade(axis: Axes, run: Numbers) -> None:
    """Shade the pushes of the initial design."""
    if len(initial := run["k"][run["phase"] == "initial"]):
        axis.axvspan(0.0, initial[-1] + 0.5, color="0.94", linewidth=0, zorder=0)
        axis.text(0.02, 0.965, "initial", transform=axis.transAxes, va="top", size=6, color="0.4")
