"""Recording compare.rrd of many runs: which of them are shown side by side, and which lines."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from deformpush.record import palette
from deformpush.record.finished import FinishedRun
from deformpush.record.poses import read_pictures, read_poses
from deformpush.study.tables import SHOWN_ERRORS, caption, markdown, run_rows, variant_rows
from deformpush.study.variants import (
    BAND_CAPTION,
    MOST,
    Differences,
    Variant,
    best,
    in_turn,
    stop_values,
    titles,
)
from deformpush.viewer import comparison
from deformpush.viewer.comparison import Line, Sight

SIDE_BY_SIDE = 6
LINES = 12
"""Up to so many runs may have a line each; of more, each variant has one with its band."""


def write(
    path: Path, runs: Sequence[FinishedRun], differences: Differences, variants: Sequence[Variant]
) -> None:
    """Write the recording."""
    names = titles(runs, differences)
    stops = {quantity.name: stop_values(runs, quantity) for quantity in SHOWN_ERRORS}
    text = about(runs, differences, variants)
    comparison.save(path, views(variants, names), lines(variants, names), stops, text)


def views(variants: Sequence[Variant], names: Mapping[str, str]) -> list[Sight]:
    """Bottom views of a few runs: in turn one of each variant, as far as their pictures can be read."""
    found: list[Sight] = []
    for run in in_turn(best(variants)):
        if len(found) == SIDE_BY_SIDE:
            break
        try:
            poses, pictures = read_poses(run.folder.contours), read_pictures(run.folder.views)
        except (OSError, ValueError):
            continue
        ended = f"{run.summary.status} after {run.summary.pushes} pushes"
        found.append(Sight(names[run.name], ended, poses, pictures))
    return found


def lines(variants: Sequence[Variant], names: Mapping[str, str]) -> list[Line]:
    """A line a run, or with many runs a line and a band a variant; colours tell the variants apart."""
    runs = [run for one in variants for run in one.runs]
    if not singly(variants):
        return [_of_variant(one, colour) for one, colour in zip(best(variants), palette.RUNS, strict=False)]
    if len(variants) == 1:
        return [
            _of_run(names[run.name], run, colour) for run, colour in zip(runs, palette.RUNS, strict=False)
        ]
    coloured = zip(variants, palette.RUNS, strict=False)
    return [_of_run(one.label, run, colour) for one, colour in coloured for run in one.runs]


def singly(variants: Sequence[Variant]) -> bool:
    """Whether runs are few enough for a line each: in the colour of their variant, or in one of their own."""
    count, colours = sum(len(one.runs) for one in variants), len(palette.RUNS)
    return count <= (LINES if 1 < len(variants) <= colours else colours)


def about(runs: Sequence[FinishedRun], differences: Differences, variants: Sequence[Variant]) -> str:
    """What is compared, as Markdown: a table of variants, and of the runs while they are few."""
    title = f"{len(runs)} runs, {len(variants)} variant" + ("s" if len(variants) > 1 else "")
    differ = ", ".join(f"`{key}`" for key in differences) or "nothing"
    text = [f"**{title}**; they differ in {differ}.", ""]
    text += [markdown(variant_rows(variants)), "", caption(variants), ""]
    if singly(variants):
        text += [markdown(run_rows(runs, differences)), ""]
    else:
        few = f"the best {MOST} of {len(variants)} variants; " if len(variants) > MOST else ""
        text += [f"In the panels of the errors: {few}{BAND_CAPTION}.", ""]
    text += ["Yellow: the goal. Red: the next push. Grey: stops, and the trail of the centroid."]
    return "\n".join(text)


def _of_run(title: str, run: FinishedRun, colour: palette.Colour) -> Line:
    return Line(title, colour, {quantity.name: run.error(quantity) for quantity in SHOWN_ERRORS})


def _of_variant(variant: Variant, colour: palette.Colour) -> Line:
    bands = {quantity.name: variant.band(quantity) for quantity in SHOWN_ERRORS}
    middle = {name: band.middle for name, band in bands.items()}
    edges = {name: (band.low, band.high) for name, band in bands.items()} if len(variant.runs) > 1 else None
    return Line(f"{variant.label} ({len(variant.runs)})", colour, middle, edges)
