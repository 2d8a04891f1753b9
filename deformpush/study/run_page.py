"""The page of one run: a bottom view to scrub through, charts that follow it, tables, settings."""

import json
from collections.abc import Sequence
from html import escape
from typing import TypedDict

import numpy as np

from deformpush.record import palette
from deformpush.record.files import FIGURE_BYTES, read_bytes
from deformpush.record.finished import FinishedRun
from deformpush.record.poses import Poses, read_pictures, read_poses
from deformpush.record.saved_config import read_text
from deformpush.study import bottom_view_svg
from deformpush.study.chart import Chart, css
from deformpush.study.page import HERE, details, facts, page, picture, table
from deformpush.study.tables import ERROR_HEADER, SHOWN_ERRORS, Rows, error_cells
from deformpush.study.variants import Configured, differing, show
from deformpush.task import TERMS

SIGMAS = 2.0
"""The band of the predicted xi reaches so many sigma to both sides."""


class PageData(TypedDict):
    """What page.js shows, a value for each k, lengths in pixels of the picture."""

    last: int
    pictures: list[str]
    """JPEG, in base64."""
    contours: list[str]
    centroids: list[str]
    paths: list[list[float] | None]
    """Start and end of push k: x, y, x, y."""
    texts: list[str]
    """HTML."""


def run_page(run: FinishedRun, defaults: Configured) -> str:
    """The page as text.

    Raises:
        OSError, ValueError: contours or pictures cannot be read.
    """
    poses, pictures = read_poses(run.folder.contours), read_pictures(run.folder.views)
    last = min(len(pictures), len(poses.contours), len(run.pushes)) - 1
    made = run.summary
    body = f'<h1>{escape(run.title)}</h1><p class="muted">{escape(run.folder.path.name)}</p>'
    body += facts(
        [
            ("ended", made.status),
            ("pushes", str(made.pushes)),
            *((f"{term.name} error", term.show(run.error(term)[-1])) for term in TERMS),
            ("time", f"{made.wall_s:.0f} s"),
        ]
    )
    reason = made.reason[:1].upper() + made.reason[1:]
    body += (
        f"<p>{escape(reason)}. {_design(made.initial_samples)} "
        f"{made.step_s:.0f} s were spent in the simulator, {made.decide_s:.1f} s on deciding.</p>"
    )
    drawn = "".join(chart.html() for chart in charts(run, last))
    body += f'<div class="two">{_view(run, poses, pictures[0], last)}'
    body += f'<div class="charts">{_phases(run)}{drawn}</div></div>'
    body += f"<h2>Settings that differ from the defaults</h2>{_settings(run, defaults)}"
    body += "<h2>Pushes</h2>" + table(push_rows(run), [f"row{k}" for k in range(len(run.pushes))])
    figure = run.folder.figures / "run.png"
    if figure.is_file() and not run.folder.figures.is_symlink():
        drawn = picture(read_bytes(figure, FIGURE_BYTES), "png")
        image = f'<img alt="four bottom views, errors, actions" src="{drawn}">'
        body += details("The figure for print", image)
    text = read_text(run.folder.config)
    body += details(f"All settings (code {run.commit})", f"<pre>{escape(text)}</pre>")
    data = json.dumps(page_data(run, poses, pictures, last))
    return page(f"{run.title}: {made.status}", body, data, (HERE / "page.js").read_text(encoding="utf-8"))


def charts(run: FinishedRun, last: int) -> list[Chart]:
    """Errors with their stops, xi against its prediction, actions within their bounds."""
    rows, made = run.pushes, []
    for term in TERMS:
        chart = Chart(term.label, last)
        chart.line(run.error(term), term.colour)
        chart.stop(run.stop(term), palette.STOP)
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
        chart.initial = int((rows["phase"] == "initial").sum())
    return made


def push_rows(run: FinishedRun) -> Rows:
    """Header and a row for each k: the push, what was expected of it, the errors after it."""
    errors = [run.error(quantity) for quantity in SHOWN_ERRORS]
    rows = [["k", "phase", "kappa", "d (mm)", "xi", "expected", *ERROR_HEADER]]
    for k, (_, row) in enumerate(run.pushes.iterrows()):
        cells = [
            f"{row['kappa']:.3f}",
            f"{1e3 * row['d']:.1f}",
            f"{row['xi']:+.3f}",
            f"{row['xi_mean']:+.3f}",
        ]
        cells = [cell if "nan" not in cell else "-" for cell in cells]
        rows.append([str(k), row["phase"] or "start", *cells, *error_cells([error[k] for error in errors])])
    return rows


def page_data(run: FinishedRun, poses: Poses, pictures: Sequence[bytes], last: int) -> PageData:
    """What the script shows, as far as all files reach."""
    ends = np.concatenate(
        [poses.camera.to_picture(poses.starts), poses.camera.to_picture(poses.ends)], axis=1
    )
    count = last + 1
    return {
        "last": last,
        "pictures": [picture(one, "jpeg").partition(",")[2] for one in pictures[:count]],
        "contours": [bottom_view_svg.points(poses, contour) for contour in poses.contours[:count]],
        "centroids": [bottom_view_svg.points(poses, c[None]) for c in poses.centroids[:count]],
        "paths": [None if np.isnan(path).any() else path.round(1).tolist() for path in ends[:count]],
        "texts": [state_text(run, k) for k in range(count)],
    }


def state_text(run: FinishedRun, k: int) -> str:
    """What push k did, and which comes next, as HTML."""
    rows = run.pushes
    lines = [f"<b>After push {k} of {run.summary.pushes}</b>" if k else "<b>Before the first push</b>"]
    if k:
        lines.append(f"{_phase(rows['phase'][k])}: xi {rows['xi'][k]:+.3f}{_expected(run, k)}")
    lines.append(", ".join(f"{term.name} {term.show(run.error(term)[k])}" for term in TERMS))
    if k + 1 < len(rows):
        u = rows.iloc[k + 1]
        push = f"kappa {u['kappa']:.3f}, d {1e3 * u['d']:.1f} mm{_expected(run, k + 1)}"
        lines.append(f"Next, {_phase(u['phase'])}: {push}")
    return "<br>".join(lines)


def _view(run: FinishedRun, poses: Poses, jpeg: bytes, last: int) -> str:
    """The bottom view with the slider that moves it."""
    view = bottom_view_svg.moving(poses, jpeg, bottom_view_svg.square_around([poses]))
    return (
        f'<div class="look"><div class="card">{view}'
        '<div class="steer"><button aria-label="back">&#8249;</button>'
        '<button aria-label="play">&#9654;</button>'
        f'<button aria-label="on">&#8250;</button><input type="range" min="0" max="{last}" value="0" '
        f'aria-label="push"></div><div class="text" id="text">{state_text(run, 0)}</div></div>'
        '<p class="muted">Yellow: the goal. Red: the next push. Grey: the way of the centroid. '
        "A tap on a chart goes to that push.</p></div>"
    )


def _design(count: int) -> str:
    return f"The first {count} pushes were the initial design." if count else "There was no initial design."


def _expected(run: FinishedRun, k: int) -> str:
    mean, std = run.pushes["xi_mean"][k], run.pushes["xi_std"][k]
    return f", expected {mean:+.3f} &plusmn; {SIGMAS * std:.3f}" if np.isfinite(mean) else ""


def _phase_colour(name: str) -> str:
    return css(palette.PHASES.get(name, palette.BOUND))


def _phase(name: str) -> str:
    return f'<span class="key"><i style="background:{_phase_colour(name)}"></i>{escape(name)}</span>'


def _phases(run: FinishedRun) -> str:
    """A bar of the phases, a cell a push."""
    cells = "".join(
        f'<i style="flex:1;background:{_phase_colour(name)}" title="{escape(name)}"></i>'
        for name in run.pushes["phase"][1:]
    )
    keys = "".join(f"<span>{_phase(name)}</span>" for name in palette.PHASES)
    return (
        f'<figure class="chart"><figcaption><b>phase</b>{keys}</figcaption>'
        f'<div class="phases">{cells}</div></figure>'
    )


def _settings(run: FinishedRun, defaults: Configured) -> str:
    differences = differing([defaults, run])
    if not differences:
        return "<p>None.</p>"
    body = [[key, show(default), show(value)] for key, (default, value) in differences.items()]
    return table([["setting", "default", "this run"], *body])
