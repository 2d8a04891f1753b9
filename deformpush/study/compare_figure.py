"""Figure compare.png: the errors of many runs by push, laid over each other."""

import io
from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from deformpush.record import palette
from deformpush.record.finished import ERRORS, Error
from deformpush.record.palette import unit
from deformpush.study.bands import SAID, band
from deformpush.study.run_figure import DPI, PUSH, STYLE, WIDTH
from deformpush.study.variants import Variant

MOST = len(palette.RUNS)
"""Variants drawn: more lines no one follows."""
SINGLE = 8
"""Up to so many runs are also drawn one by one."""
ENDED = "dot: a run ended; hollow: without reaching the goal"


def draw(variants: Sequence[Variant]) -> bytes:
    """PNG of four panels: three errors with a line and a band for each variant, and who got there when."""
    shown = best(variants)
    singly = sum(len(variant.runs) for variant in shown) <= SINGLE
    with matplotlib.rc_context(STYLE):
        rows = -(-len(shown) // 2)
        figure = Figure(figsize=(WIDTH, 5.0 + 0.17 * rows), layout="constrained")
        *above, last = figure.subplots(2, 2).flat
        for axis, error in zip(above, ERRORS, strict=False):
            panel(axis, shown, error, singly)
        arrivals(last, shown)
        handles = [_handle(i, variant) for i, variant in enumerate(shown)]
        figure.legend(handles=handles, loc="outside upper left", ncols=1 if rows == 1 else 2, fontsize=7)
        figure.supxlabel("; ".join([*_left_out(variants), SAID, *[ENDED] * singly]), size=6, color="0.4")
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def panel(axis: Axes, variants: Sequence[Variant], error: Error, singly: bool) -> None:
    """One error over k: median and middle half of each variant, its stop dashed, `singly` all runs too."""
    for i, variant in enumerate(variants):
        colour, many = unit(palette.RUNS[i]), len(variant.runs) > 1
        spread = band(variant, error)
        k = np.arange(len(spread.middle))
        axis.plot(k, spread.middle, color=colour, linewidth=1.6, zorder=4)
        if many:
            axis.fill_between(k, spread.low, spread.high, color=colour, alpha=0.2, linewidth=0, zorder=2)
        for run in variant.runs if singly else ():
            curve = run.error(error)
            if many:
                axis.plot(curve, color=colour, linewidth=0.5, alpha=0.7, zorder=3)
            fill = colour if run.summary.status == "reached" else "white"
            end = (len(curve) - 1, curve[-1])
            axis.plot(*end, "o", color=colour, markerfacecolor=fill, markersize=3, zorder=5)
    for stop in {run.stop(error) for variant in variants for run in variant.runs}:
        if np.isfinite(stop):
            axis.axhline(stop, color=unit(palette.STOP), linestyle=(0, (4, 3)), linewidth=0.9, zorder=1)
            axis.annotate(
                f"stop {stop:.3g}", (0, stop), xycoords=("axes fraction", "data"), xytext=(3, 1.5),
                textcoords="offset points", size=6, color="0.35", zorder=6,
            )  # fmt: skip
    _frame(axis, error.label, None)


def arrivals(axis: Axes, variants: Sequence[Variant]) -> None:
    """Share of each variant's runs that have reached the goal by push k."""
    longest = max(run.summary.pushes for variant in variants for run in variant.runs)
    for i, variant in enumerate(variants):
        share = 100 * arrived(variant, longest)
        colour = unit(palette.RUNS[i])
        axis.step(range(longest + 1), share, where="post", color=colour, linewidth=1.6)
    _frame(axis, "runs at the goal (%)", 103)


def arrived(variant: Variant, longest: int) -> np.ndarray:
    """Share of the runs that had reached the goal after push 0, ..., `longest`."""
    ends = np.array([run.summary.pushes for run in variant.runs if run.summary.status == "reached"])
    return np.array([(ends <= k).sum() for k in range(longest + 1)]) / len(variant.runs)


def best(variants: Sequence[Variant]) -> list[Variant]:
    """At most `MOST` variants: all, or those that reached the goal most often, then soonest."""
    if len(variants) <= MOST:
        return list(variants)
    return sorted(
        variants,
        key=lambda one: (
            -one.reached / len(one.runs),
            float(np.median([run.summary.pushes for run in one.runs])),
        ),
    )[:MOST]


def _left_out(variants: Sequence[Variant]) -> list[str]:
    return [f"the best {MOST} of {len(variants)} variants"] if len(variants) > MOST else []


def _handle(i: int, variant: Variant) -> Line2D:
    n = len(variant.runs)
    text = f"{variant.label}: {variant.reached} of {n} run{'s' * (n > 1)} reached the goal"
    return Line2D([], [], color=unit(palette.RUNS[i]), linewidth=1.6, label=text)


def _frame(axis: Axes, label: str, top: float | None) -> None:
    axis.set(xlabel=PUSH, ylabel=label, xlim=(0, None), ylim=(0, top))
    axis.spines["right"].set_visible(False)
