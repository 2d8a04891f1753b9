"""The page of a sweep: variants, errors by push with their bands, where the runs ended, tables."""

from collections.abc import Mapping, Sequence
from html import escape

from deformpush.record import palette
from deformpush.record.finished import FinishedRun
from deformpush.record.pictures import encode
from deformpush.record.poses import read_poses, read_views
from deformpush.study import bottom_view_svg
from deformpush.study.chart import Chart
from deformpush.study.find_runs import FoundRuns
from deformpush.study.page import facts, page, table
from deformpush.study.tables import caption, run_rows, variant_rows
from deformpush.study.variants import (
    BAND_CAPTION,
    Variant,
    best,
    differing,
    in_turn,
    show,
    stop_values,
    titles,
    variants,
)
from deformpush.task import TERMS

MOST_VIEWS, MOST_ROWS, VIEW_PX, QUALITY = 24, 300, 240, 75


def sweep_page(title: str, found: FoundRuns) -> str:
    """The page as text."""
    runs = found.runs
    differences = differing(runs)
    groups = variants(runs, differences)
    shown = best(groups)
    reached = sum(run.summary.status == "reached" for run in runs)
    hours = sum(run.summary.wall_s for run in runs) / 3600
    body = f"<h1>{escape(title)}</h1>" + facts(
        [
            ("runs", str(len(runs))),
            ("reached the goal", f"{reached} of {len(runs)}"),
            ("variants", str(len(groups))),
            ("pushes", str(sum(run.summary.pushes for run in runs))),
            ("time in all", f"{hours:.1f} h" if hours >= 1 else f"{60 * hours:.0f} min"),
        ]
    )
    body += f'<h2>Variants</h2>{table(variant_rows(groups))}<p class="muted">{caption(groups)}</p>'
    if len(shown) < len(groups):
        body += f'<p class="muted">The charts show the {len(shown)} that reached the goal most often.</p>'
    drawn = "".join(chart.html() for chart in charts(shown, runs))
    body += f'<h2>Errors by push</h2><div class="charts tall">{drawn}</div>'
    body += f'<p class="muted">{BAND_CAPTION[0].upper()}{BAND_CAPTION[1:]}.</p>'
    views = _views(in_turn(groups)[:MOST_VIEWS], titles(runs, differences))
    body += f'<h2>Where they ended</h2><div class="last">{views}</div>'
    if len(runs) > MOST_VIEWS:
        body += f'<p class="muted">{MOST_VIEWS} of {len(runs)} runs, in turn one of each variant.</p>'
    rows = [[key, ", ".join(dict.fromkeys(map(show, values)))] for key, values in differences.items()]
    body += "<h2>Settings that differ</h2>"
    body += table([["setting", "values"], *rows]) if rows else "<p>None.</p>"
    listed = run_rows(runs, differences)
    body += "<h2>Runs</h2>" + table(listed[: MOST_ROWS + 1])
    if len(runs) > MOST_ROWS:
        body += f'<p class="muted">The first {MOST_ROWS} of {len(runs)}; compare.csv has all.</p>'
    if found.skipped:
        body += "<h2>Left out</h2>" + table([["run", "reason"], *map(list, found.skipped)])
    return page(title, body)


def charts(shown: Sequence[Variant], runs: Sequence[FinishedRun]) -> list[Chart]:
    """Each error with a line and a band a variant and the stops of all runs, and the share at the goal."""
    last = max(run.summary.pushes for variant in shown for run in variant.runs)
    made = []
    for term in TERMS:
        chart = Chart(term.label, last)
        for variant, colour in zip(shown, palette.RUNS, strict=False):
            band = variant.band(term)
            if len(variant.runs) > 1:
                chart.band(band.low, band.high, colour)
            chart.line(band.middle, colour, variant.label)
        for stop in stop_values(runs, term):
            chart.stop(stop, palette.STOP)
        made.append(chart)
    chart = Chart("runs at the goal (%)", last)
    for variant, colour in zip(shown, palette.RUNS, strict=False):
        chart.steps(100 * variant.arrived(last), colour, variant.label)
    return [*made, chart]


def _views(runs: Sequence[FinishedRun], names: Mapping[str, str]) -> str:
    """The last bottom view of each run, as far as it can be read; of the same part of the table in all."""
    found = []
    for run in runs:
        try:
            found.append((run, read_poses(run.folder.contours), read_views(run.folder.views)))
        except (OSError, ValueError):
            continue
    made = []
    for run, poses, pictures in found:
        last = min(len(pictures), len(poses.contours)) - 1
        seen = bottom_view_svg.square_around([one for _, one, _ in found if one.camera == poses.camera])
        view = bottom_view_svg.still(poses, last, encode(pictures[last], VIEW_PX, QUALITY), seen)
        text = f"{names[run.name]}: {run.summary.status}, {run.summary.pushes} pushes"
        made.append(f"<figure>{view}<figcaption>{escape(text)}</figcaption></figure>")
    return "".join(made)
