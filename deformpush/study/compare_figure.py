"""Figure compare.png: the errors of many runs by push, laid over each other."""

import io
from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from deformpush.record import palette
from deformpush.record.palette import unit
from deformpush.study.run_figure import DASHES, DPI, PUSH, STYLE, WIDTH
from deformpush.study.variants import BAND_CAPTION, MOST, Variant, best, stop_values
from deformpush.task import TERMS, Quantity

SINGLE = 8
"""Up to so many runs are also drawn one by one."""
END_CAPTION = "dot: a run ended; hollow: without reaching the goal"


def draw(variants: Sequence[Variant]) -> bytes:
    """The figure as a PNG."""
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure(variants).savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def figure(variants: Sequence[Variant]) -> Figure:
    """A panel for each error with a line and a band for each variant, and one for who got there when."""
    shown = best(variants)
    singly = sum(len(variant.runs) for variant in shown) <= SINGLE
    above, legend_rows = -(-(len(TERMS) + 1) // 2), -(-len(shown) // 2)
    made = Figure(figsize=(WIDTH, 2.5 * above + 0.17 * legend_rows), layout="constrained")
    axes = list(made.subplots(above, 2).flat)
    for axis, term in zip(axes, TERMS, strict=False):
        panel(axis, shown, term, singly)
    arrivals(axes[len(TERMS)], shown)
    for spare in axes[len(TERMS) + 1 :]:
        spare.remove()
    handles = [_handle(i, variant) for i, variant in enumerate(shown)]
    columns = 1 if legend_rows == 1 else 2
    made.legend(handles=handles, loc="outside upper left", ncols=columns, fontsize=7)
    made.supxlabel(
        "; ".join([*_left_out(variants), BAND_CAPTION, *[END_CAPTION] * singly]), size=6, color="0.4"
    )
    return made


def panel(axis: Axes, variants: Sequence[Variant], quantity: Quantity, singly: bool) -> None:
    """One error over k: median and middle half of each variant, its stop dashed, `singly` all runs too."""
    for i, variant in enumerate(variants):
        colour, many = unit(palette.RUNS[i]), len(variant.runs) > 1
        band = variant.band(quantity)
        k = np.arange(len(band.middle))
        axis.plot(k, band.middle, color=colour, linewidth=1.6, zorder=4)
        if many:
            axis.fill_between(k, band.low, band.high, color=colour, alpha=0.2, linewidth=0, zorder=2)
        for run in variant.runs if singly else ():
            curve = run.error(quantity)
            if many:
                axis.plot(curve, color=colour, linewidth=0.5, alpha=0.7, zorder=3)
            fill = colour if run.summary.status == "reached" else "white"
            end = (len(curve) - 1, curve[-1])
            axis.plot(*end, "o", color=colour, markerfacecolor=fill, markersize=3, zorder=5)
    for stop in stop_values([run for variant in variants for run in variant.runs], quantity):
        axis.axhline(stop, color=unit(palette.STOP), linestyle=DASHES, linewidth=0.9, zorder=1)
        axis.annotate(
            f"stop {stop:.3g}", (0, stop), xycoords=("axes fraction", "data"), xytext=(3, 1.5),
            textcoords="offset points", size=6, color="0.35", zorder=6,
        )  # fmt: skip
    _frame(axis, quantity.label, None)


def arrivals(axis: Axes, variants: Sequence[Variant]) -> None:
    """Share of each variant's runs that have reached the goal by push k."""
    longest = max(run.summary.pushes for variant in variants for run in variant.runs)
    for i, variant in enumerate(variants):
        share = 100 * variant.arrived(longest)
        axis.step(range(longest + 1), share, where="post", color=unit(palette.RUNS[i]), linewidth=1.6)
    _frame(axis, "runs at the goal (%)", 103)


def _left_out(variants: Sequence[Variant]) -> list[str]:
    return [f"the best {MOST} of {len(variants)} variants"] if len(variants) > MOST else []


def _handle(i: int, variant: Variant) -> Line2D:
    n = len(variant.runs)
    text = f"{variant.label}: {variant.reached} of {n} run{'s' * (n > 1)} reached the goal"
    return Line2D([], [], color=unit(palette.RUNS[i]), linewidth=1.6, label=text)


def _frame(axis: Axes, label: str, top: float | None) -> None:
    axis.set(xlabel=PUSH, ylabel=label, xlim=(0, None), ylim=(0, top))
    axis.spines["right"].set_visible(False)
