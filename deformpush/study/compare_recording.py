"""What compare.rrd shows of many runs: which of them side by side, and which lines."""

from collections.abc import Sequence
from itertools import chain, zip_longest
from typing import Any

import numpy as np

from deformpush.record import palette
from deformpush.record.finished import ERRORS, FinishedRun
from deformpush.record.poses import read_pictures, read_trace
from deformpush.study.bands import SAID, band
from deformpush.study.compare_figure import MOST, best
from deformpush.study.tables import Rows, counted, run_rows, variant_rows
from deformpush.study.variants import Variant, titles
from deformpush.viewer.comparison import Line, Sight

SIDE_BY_SIDE = 6
LINES = 12
"""Up to so many runs may have a line each; of more, each variant has one with its band."""


def sights(runs: Sequence[FinishedRun], variants: Sequence[Variant], names: dict[str, str]) -> list[Sight]:
    """Bottom views of a few runs: in turn one of each variant, as far as their pictures can be read."""
    found: list[Sight] = []
    for run in in_turn(best(variants)):
        if len(found) == SIDE_BY_SIDE:
            break
        try:
            trace, pictures = read_trace(run.folder.contours), read_pictures(run.folder.views)
        except (OSError, ValueError):
            continue
        ended = f"{run.summary.status} after {run.summary.pushes} pushes"
        found.append(Sight(names[run.name], ended, trace, pictures))
    return found


def in_turn(variants: Sequence[Variant]) -> list[FinishedRun]:
    """The first run of each variant, then the second of each, and so on."""
    return [run for run in chain(*zip_longest(*(one.runs for one in variants))) if run is not None]


def lines(variants: Sequence[Variant], names: dict[str, str]) -> list[Line]:
    """A line a run, or with many runs a line and a band a variant; colours tell the variants apart."""
    runs = [run for one in variants for run in one.runs]
    if not singly(variants):
        return [_spread(i, one) for i, one in enumerate(best(variants))]
    if len(variants) == 1:
        return [_single(names[run.name], i, run) for i, run in enumerate(runs)]
    return [_single(one.label, i, run) for i, one in enumerate(variants) for run in one.runs]


def singly(variants: Sequence[Variant]) -> bool:
    """Whether runs are few enough for a line each: in the colour of their variant, or in one of their own."""
    count, colours = sum(len(one.runs) for one in variants), len(palette.RUNS)
    return count <= (LINES if 1 < len(variants) <= colours else colours)


def stops(runs: Sequence[FinishedRun]) -> dict[str, list[float]]:
    """The different stop values of each error."""
    found = {error.name: sorted({run.stop(error) for run in runs}) for error in ERRORS}
    return {name: [value for value in values if np.isfinite(value)] for name, values in found.items()}


def about(runs: Sequence[FinishedRun], difference: dict[str, list[Any]], variants: Sequence[Variant]) -> str:
    """What is compared, as Markdown: a table of variants, and of the runs while they are few."""
    title = f"{len(runs)} runs, {len(variants)} variant" + ("s" if len(variants) > 1 else "")
    differ = ", ".join(f"`{key}`" for key in difference) or "nothing"
    text = [
        f"**{title}**; they differ in {differ}.",
        "",
        _markdown(variant_rows(variants)),
        "",
        counted(variants),
        "",
    ]
    if singly(variants):
        text += [_markdown(run_rows(runs, difference)), ""]
    else:
        few = f"the best {MOST} of {len(variants)} variants; " if len(variants) > MOST else ""
        text += [f"In the panels of the errors: {few}{SAID}.", ""]
    text += ["Yellow: the goal. Red: the next push. Grey: stops, and the trail of the centroid."]
    return "\n".join(text)


def short_names(runs: Sequence[FinishedRun], difference: dict[str, list[Any]]) -> dict[str, str]:
    """Title by name of the run."""
    return {run.name: title for run, title in zip(runs, titles(runs, difference), strict=True)}


def _single(title: str, i: int, run: FinishedRun) -> Line:
    return Line(title, _colour(i), {error.name: run.error(error) for error in ERRORS})


def _spread(i: int, variant: Variant) -> Line:
    spreads = {error.name: band(variant, error) for error in ERRORS}
    middle = {name: one.middle for name, one in spreads.items()}
    edges = {name: (one.low, one.high) for name, one in spreads.items()} if len(variant.runs) > 1 else None
    return Line(f"{variant.label} ({len(variant.runs)})", _colour(i), middle, edges)


def _colour(i: int) -> palette.Colour:
    return palette.RUNS[i]


def _markdown(rows: Rows) -> str:
    """A Markdown table; a bar in a cell would end it."""
    header, *body = [[cell.replace("|", "/") for cell in row] for row in rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in [header, ["---"] * len(header), *body])
