"""The page of one run: a bottom view to scrub through, charts that follow it, tables, settings."""

import json
from html import escape
from typing import Any

import numpy as np

from deformpush.record import palette
from deformpush.record.finished import ERRORS, FinishedRun
from deformpush.record.poses import Trace, read_pictures, read_trace
from deformpush.study import bottom_view_svg as glimpse
from deformpush.study.chart import Chart, css
from deformpush.study.page import HERE, details, facts, page, picture, table
from deformpush.study.variants import Configured, differing, show

SIGMAS = 2.0
"""The band of the predicted xi reaches so many sigma to both sides."""


def run_page(run: FinishedRun, defaults: Configured) -> str:
    """The page as text.

    Raises:
        OSError, ValueError: contours or pictures cannot be read.
    """
    trace, pictures = read_trace(run.folder.contours), read_pictures(run.folder.views)
    last = min(len(pictures), len(trace.contours), len(run.pushes)) - 1
    made = run.summary
    body = f'<h1>{escape(run.title)}</h1><p class="muted">{escape(run.folder.path.name)}</p>'
    body += facts(
        [
            ("ended", made.status),
            ("pushes", str(made.pushes)),
            *((error.title, error.show(run.error(error)[-1])) for error in ERRORS[:3]),
            ("time", f"{made.wall_s:.0f} s"),
        ]
    )
    reason = made.reason[:1].upper() + made.reason[1:]
    body += (
        f"<p>{escape(reason)}. {_design(made.initial_samples)} "
        f"{made.step_s:.0f} s were spent in the simulator, {made.decide_s:.1f} s on deciding.</p>"
    )
    view = (
        f'<div class="look"><div class="card">{glimpse.svg(trace, 0, pictures[0], glimpse.bounds([trace]))}'
        '<div class="steer"><button aria-label="back">&#8249;</button>'
        '<button aria-label="play">&#9654;</button>'
        f'<button aria-label="on">&#8250;</button><input type="range" min="0" max="{last}" value="0" '
        f'aria-label="push"></div><div class="said" id="said">{said(run, 0)}</div></div>'
        '<p class="muted">Yellow: the goal. Red: the next push. Grey: the way of the centroid. '
        "A tap on a chart goes to that push.</p></div>"
    )
    body += f'<div class="two">{view}<div class="charts">{_phases(run)}{charts(run, last)}</div></div>'
    body += f"<h2>Settings that differ from the defaults</h2>{_settings(run, defaults)}"
    body += "<h2>Pushes</h2>" + table(_rows(run), [f"row{k}" for k in range(len(run.pushes))])
    figure = run.folder.figures / "run.png"
    if figure.is_file():
        image = f'<img alt="four bottom views, errors, actions" src="{picture(figure.read_bytes(), "png")}">'
        body += details("The figure for print", image)
    text = run.folder.config.read_text(encoding="utf-8")
    body += details(f"All settings (code {run.commit})", f"<pre>{escape(text)}</pre>")
    data = json.dumps(_data(run, trace, pictures, last)).replace("</", "<\\/")
    script = (HERE / "page.js").read_text(encoding="utf-8")
    tail = (
        f'<script type="application/json" id="run">{data}</script>\n<script type="module">{script}</script>'
    )
    return page(f"{run.title}: {made.status}", body, tail)


def charts(run: FinishedRun, last: int) -> str:
    """Errors with their stops, xi against its prediction, actions within their bounds."""
    rows, made = run.pushes, []
    for error in ERRORS[:3]:
        chart = Chart(error.label, last)
        chart.line(run.error(error), error.colour)
        chart.stop(run.stop(error), palette.STOP)
        made.append(chart)
    chart = Chart("change of error xi (-)", last)
    mean, reach = rows["xi_mean"].to_numpy(), SIGMAS * rows["xi_std"].to_numpy()
    chart.band(mean - reach, mean + reach, palette.BOUND, f"predicted, {SIGMAS:g} sigma")
    chart.line(mean, palette.BOUND, width=1.2)
    chart.dots(rows["xi"].to_numpy(), palette.XI, "as it came")
    made.append(chart)
    for name, title, colour, scale in (
        ("kappa", "contour ratio kappa (-)", palette.KAPPA, 1.0),
        ("d", "distance d (mm)", palette.D, 1e3),
    ):
        chart = Chart(title, last)
        low, high = (scale * rows[f"{name}_{side}"].to_numpy() for side in ("min", "max"))
        chart.band(low, high, colour, "bounds")
        chart.dots(scale * rows[name].to_numpy(), colour, "push")
        made.append(chart)
    for chart in made:
        chart.shade(int((rows["phase"] == "initial").sum()))
    return "".join(chart.html() for chart in made)


def said(run: FinishedRun, k: int) -> str:
    """What push k did, and which comes next, as HTML."""
    rows = run.pushes
    lines = [f"<b>After push {k} of {run.summary.pushes}</b>" if k else "<b>Before the first push</b>"]
    if k:
        lines.append(f"{_phase(rows['phase'][k])}: xi {rows['xi'][k]:+.3f}{_expected(rows.iloc[k])}")
    errors = [f"{error.name} {error.show(run.error(error)[k])}" for error in ERRORS[:3]]
    lines.append(", ".join(errors))
    if k + 1 < len(rows):
        u = rows.iloc[k + 1]
        lines.append(
            f"Next, {_phase(u['phase'])}: kappa {u['kappa']:.3f}, d {1e3 * u['d']:.1f} mm{_expected(u)}"
        )
    return "<br>".join(lines)


def _design(count: int) -> str:
    return f"The first {count} pushes were the initial design." if count else "There was no initial design."


def _expected(row: Any) -> str:
    mean = row["xi_mean"]
    return f", expected {mean:+.3f} &plusmn; {SIGMAS * row['xi_std']:.3f}" if np.isfinite(mean) else ""


def _phase(name: str) -> str:
    return f'<span class="key"><i style="background:{css(palette.PHASES[name])}"></i>{name}</span>'


def _phases(run: FinishedRun) -> str:
    """A bar of the phases, a cell a push."""
    colours = [(name, css(palette.PHASES.get(name, palette.BOUND))) for name in run.pushes["phase"][1:]]
    cells = "".join(f'<i style="flex:1;background:{colour}" title="{name}"></i>' for name, colour in colours)
    keys = "".join(f"<span>{_phase(name)}</span>" for name in palette.PHASES)
    return (
        f'<figure class="chart"><figcaption><b>phase</b>{keys}</figcaption>'
        f'<div class="phases">{cells}</div></figure>'
    )


def _settings(run: FinishedRun, defaults: Configured) -> str:
    difference = differing([defaults, run])
    if not difference:
        return "<p>None.</p>"
    body = [[key, show(default), show(value)] for key, (default, value) in difference.items()]
    return table([["setting", "default", "this run"], *body])


def _rows(run: FinishedRun) -> list[list[str]]:
    header = [
        "k",
        "phase",
        "kappa",
        "d (mm)",
        "xi",
        "expected",
        *(f"{e.name} ({e.unit})" for e in ERRORS[:3]),
        "e_T",
    ]
    values = [run.error(error) for error in ERRORS]
    body = []
    for k, (_, row) in enumerate(run.pushes.iterrows()):
        cells = [
            f"{row['kappa']:.3f}",
            f"{1e3 * row['d']:.1f}",
            f"{row['xi']:+.3f}",
            f"{row['xi_mean']:+.3f}",
        ]
        cells = [cell if "nan" not in cell else "-" for cell in cells]
        last = [f"{error[k]:.{e.digits}f}" for error, e in zip(values, ERRORS, strict=True)]
        body.append([str(k), row["phase"] or "start", *cells, *last])
    return [header, *body]


def _data(run: FinishedRun, trace: Trace, pictures: list[bytes], last: int) -> dict[str, Any]:
    """What the script shows, for every k."""
    path = [None if np.isnan(ends).any() else [round(float(v), 1) for v in ends] for ends in _paths(trace)]
    return {
        "last": last,
        "pictures": [picture(one, "jpeg").partition(",")[2] for one in pictures[: last + 1]],
        "contours": [glimpse.points(trace, contour) for contour in trace.contours[: last + 1]],
        "centroids": [glimpse.points(trace, c[None]) for c in trace.centroids[: last + 1]],
        "paths": path[: last + 1],
        "said": [said(run, k) for k in range(last + 1)],
    }


def _paths(trace: Trace) -> np.ndarray:
    """Start and end of every push `(K+1, 4)` in pixels."""
    to_picture = trace.camera.to_picture
    return np.concatenate([to_picture(trace.starts), to_picture(trace.ends)], axis=1)
