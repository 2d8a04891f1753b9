"""Figure regret.png: what the pushes of a run gained beside others from the same states, and what was foreseen."""

import io
from typing import Any

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
REACH = 4.0
"""Standardised errors are drawn up to here; what lies beyond stands at the edge."""
OTHERS, MADE, BEST, RANDOM, MODEL = (
    palette.BOUND, palette.XI, palette.FORECAST, palette.D, palette.OBJECT,
)  # fmt: skip
Array = np.ndarray


def draw(rows: Columns, trials: Columns) -> bytes:
    """The figure as a PNG."""
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure(rows, trials).savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def figure(rows: Columns, trials: Columns) -> Figure:
    """Outcomes, regret, its sum, calibration by push, standardised errors, forecast against outcome."""
    made = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    axes = list(made.subplots(3, 2).flat)
    run = {name: np.array(values) for name, values in rows.items()}
    tried = {name: np.array(values) for name, values in trials.items()}
    outcomes(axes[0], run, tried)
    regret(axes[1], run)
    cumulative(axes[2], run)
    forecasts(axes[3], tried)
    inside(axes[4], run)
    errors(axes[5], tried)
    for axis, letter in zip(axes, "abcdef", strict=True):
        axis.spines["right"].set_visible(False)
        axis.set_title(f"({letter}) {axis.get_title()}", loc="left", fontweight="bold")
        axis.set_title("")
    for axis in (axes[0], axes[1], axes[2], axes[4], axes[5]):
        axis.set(xlabel=PUSH, xlim=(run["k"][0] - 0.7, run["k"][-1] + 0.7))
        axis.xaxis.set_major_locator(MaxNLocator(integer=True))
        _shade(axis, run)
    return made
