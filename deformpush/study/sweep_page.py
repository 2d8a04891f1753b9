"""The page of a sweep: variants, errors by push with their bands, where the runs ended, tables."""

from collections.abc import Sequence
from html import escape

from deformpush.record import palette
from deformpush.record.finished import ERRORS, FinishedRun
from deformpush.record.picture import encode
from deformpush.record.poses import read_trace, read_views
from deformpush.study import bottom_view_svg as glimpse
from deformpush.study.bands import SAID, band
from deformpush.study.chart import Chart
from deformpush.study.compare_figure import arrived, best
from deformpush.study.compare_recording import in_turn, short_names, stops
from deformpush.study.find_runs import Gathered
from deformpush.study.page import facts, page, table
from deformpush.study.tables import counted, run_rows, variant_rows
from deformpush.study.variants import Variant, differing, show, variants

MOST_VIEWS, MOST_ROWS, VIEW_PX, QUALITY = 24, 300, 240, 75


def sweep_page(title: str, found: Gathered) -> str:
    """The page as text."""
    runs = found.runs
    difference = differing(runs)
    groups = variants(runs, difference)
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
    body += f'<h2>Variants</h2>{table(variant_rows(groups))}<p class="muted">{counted(groups)}</p>'
    if len(shown) < len(groups):
        body += f"<p class=muted>The charts show the {len(shown)} that reached the goal most often.</p>"
    body += f'<h2>Errors by push</h2><div class="charts tall">{charts(shown, stops(runs))}</div>'
    body += f'<p class="muted">{SAID[0].upper()}{SAID[1:]}.</p>'
    names = short_names(runs, difference)
    body += f'<h2>Where they ended</h2><div class="last">{_views(in_turn(groups)[:MOST_VIEWS], names)}</div>'
    if len(runs) > MOST_VIEWS:
        body += f"<p class=muted>{MOST_VIEWS} of {len(runs)} runs, in turn one of each variant.</p>"
    rows = [[key, ", ".join(dict.fromkeys(map(show, values)))] for key, values in difference.items()]
    body += "<h2>Settings that differ</h2>" + (
        table([["setting", "values"], *rows]) if rows else "<p>None.</p>"
    )
    listed = run_rows(runs, difference)
    body += "<h2>Runs</h2>" + table(listed[: MOST_ROWS + 1])
    if len(runs) > MOST_ROWS:
        body += f"<p class=muted>The first {MOST_ROWS} of {len(runs)}; compare.csv has all.</p>"
    if found.skipped:
        body += "<h2>Left out</h2>" + table([["run", "reason"], *map(list, found.skipped)])
    return page(title, body)


def charts(shown: Sequence[Variant], stop_values: dict[str, list[float]]) -> str:
    """Three errors with a line and a band a variant, and the share of runs at the goal."""
    last = max(run.summary.pushes for variant in shown for run in variant.runs)
    made = []
    for error in ERRORS[:3]:
        chart = Chart(error.label, last)
        for variant, colour in zip(shown, palette.RUNS, strict=False):
            spread = band(variant, error)
            if len(variant.runs) > 1:
                chart.band(spread.low, spread.high, colour)
            chart.line(spread.middle, colour, variant.label)
        for stop in stop_values[error.name]:
            chart.stop(stop, palette.STOP)
        made.append(chart)
    chart = Chart("runs at the goal (%)", last)
    for variant, colour in zip(shown, palette.RUNS, strict=False):
        chart.steps(100 * arrived(variant, last), colour, variant.label)
    return "".join(chart.html() for chart in [*made, chart])


def _views(runs: Sequence[FinishedRun], names: dict[str, str]) -> str:
    """The last bottom view of each run, as far as it can be read; of the same part of the table in all."""
    found = []
    for run in runs:
        try:
            found.append((run, read_trace(run.folder.contours), read_views(run.folder.views)))
        except (OSError, ValueError):
            continue
    made = []
    for run, trace, pictures in found:
        last = min(len(pictures), len(trace.contours)) - 1
        seen = glimpse.bounds([one for _, one, _ in found if one.camera == trace.camera])
        view = glimpse.small(trace, last, encode(pictures[last], VIEW_PX, QUALITY), seen)
        text = f"{escape(names[run.name])}: {run.summary.status}, {run.summary.pushes} pushes"
        made.append(f"<figure>{view}<figcaption>{text}</figcaption></figure>")
    return "".join(made)
