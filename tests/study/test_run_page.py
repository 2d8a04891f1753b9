"""The page of a run: every number on it is one of the run's."""

import base64
import json
import re
import shutil

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.record.finished import read
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_pictures, read_poses
from deformpush.study import run_page
from deformpush.study.page import HERE
from deformpush.task import TERMS
from tests.record.synthetic import SyntheticRun
from tests.study import html_tree
from tests.study.folders import CONFIG, columns, numbers, written

LAST, INITIAL = 12, 10
ERRORS = ["position", "angle", "shape"]


class Defaults:
    """Settings of a run without overrides."""

    settings = {"acq.w": 2.0, "seed": 0, "object.thickness": 0.02}  # noqa: RUF012
    options = {"object": "rect", "acquisition": "lcb", "record": "off"}  # noqa: RUF012


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of 12 pushes, two of them chosen by a model."""
    made = SyntheticRun(LAST)
    config = CONFIG.format(seed=0, w=1.0, name="rect", thickness=0.02, d=0.03, rrd=False, position_m=0.02)
    path = tmp_path_factory.mktemp("page") / "the run"
    return read(written(path, made.info, made.records(), "reached", config), "the run")


@pytest.fixture(scope="module")
def text(run):
    return run_page.run_page(run, Defaults())


@pytest.fixture(scope="module")
def tree(text):
    return html_tree.read(text)


@pytest.fixture(scope="module")
def data(tree):
    return json.loads(tree.one("script", type_="application/json").text)


def error(run, term) -> np.ndarray:
    """An error as pushes.csv has it, in the unit of people."""
    return np.abs(numbers(run.folder.path, term.column)) * term.scale


def in_digits(run, k) -> list[str]:
    return [f"{error(run, term)[k]:.{digits}f}" for term, digits in zip(TERMS, (1, 1, 3), strict=True)]


def test_the_head_tells_how_it_ended(run, tree):
    assert tree.one("title").text == "rect, error model, lcb, seed 0: reached"
    assert (tree.one("h1").text, tree.all("p", class_="muted")[0].text) == (run.title, "the run")
    position, angle, shape = in_digits(run, -1)
    boxes = [(box.one("span").text, box.one("b").text) for box in tree.one(class_="facts").all("div")]
    assert boxes == [
        ("ended", "reached"),
        ("pushes", "12"),
        ("position error", f"{position} mm"),
        ("angle error", f"{angle} deg"),
        ("shape error", shape),
        ("time", "2 s"),
    ]
    assert "As asked. The first 10 pushes were the initial design." in tree.one("main").text


def test_the_table_has_a_row_for_every_push(run, tree):
    section = tree.after("Pushes")
    header, *rows = section.rows
    assert header[:6] == ["k", "phase", "kappa", "d (mm)", "xi", "expected"]
    assert header[6:] == ["position (mm)", "angle (deg)", "shape (-)", "e_T"]
    told = columns(run.folder.path)
    assert [row.attributes.get("id") for row in section.all("tr")[1:]] == [f"row{k}" for k in range(LAST + 1)]
    for k, row in enumerate(rows):
        kappa, d, xi, mean = (float(told[name][k] or "nan") for name in ("kappa", "d", "xi", "xi_mean"))
        push = [f"{kappa:.3f}", f"{1e3 * d:.1f}", f"{xi:+.3f}", f"{mean:+.3f}"]
        push = ["-" if "nan" in cell else cell for cell in push]
        assert row[:6] == [str(k), told["phase"][k] or "start", *push]
        assert row[6:] == [*in_digits(run, k), f"{float(told['e_T'][k]):.3f}"]
    assert [row[5] == "-" for row in rows] == [True] * (INITIAL + 1) + [False] * 2


def test_the_charts_show_errors_xi_and_actions(run):
    charts = run_page.charts(run, LAST)
    titles = [*(term.label for term in TERMS), "change of error xi (-)"]
    assert [chart.title for chart in charts] == [*titles, "contour ratio kappa (-)", "distance d (mm)"]
    assert {chart.initial for chart in charts} == {INITIAL}
    for chart, term, stop in zip(charts, TERMS, (20.0, 7.0, 0.15), strict=False):
        line, level = chart.marks
        np.testing.assert_allclose(line.values, error(run, term))
        assert (line.kind, line.colour) == ("line", term.colour)
        assert (level.key, level.colour) == (f"stop {stop:.3g}", palette.STOP)
        assert level.values == pytest.approx([stop] * (LAST + 1))
    told = {name: np.array(numbers(run.folder.path, name)) for name in ("xi", "xi_mean", "xi_std")}
    band, line, dots = charts[3].marks
    mean, std = told["xi_mean"][INITIAL + 1 :], told["xi_std"][INITIAL + 1 :]
    np.testing.assert_allclose(band.values, [*(mean - 2 * std), *(mean + 2 * std)[::-1]])
    np.testing.assert_allclose(line.values, mean)
    np.testing.assert_allclose(dots.values, told["xi"][1:])
    assert (band.key, dots.key, dots.colour) == ("predicted, 2 sigma", "as it came", palette.XI)
    for chart, name, scale, colour in zip(
        charts[4:], ("kappa", "d"), (1.0, 1e3), (palette.KAPPA, palette.D), strict=True
    ):
        band, dots = chart.marks
        low, high = (
            scale * np.array(numbers(run.folder.path, f"{name}_{end}"))[1:] for end in ("min", "max")
        )
        np.testing.assert_allclose(band.values, [*low, *high[::-1]])
        np.testing.assert_allclose(dots.values, scale * np.array(numbers(run.folder.path, name)[1:]))
        assert (band.key, dots.key, dots.colour) == ("bounds", "push", colour)


def test_every_chart_is_on_the_page_with_every_mark(run, tree):
    figures = [figure for figure in tree.all("figure", class_="chart") if figure.all("svg")]
    for figure, chart in zip(figures, run_page.charts(run, LAST), strict=True):
        caption = figure.one("figcaption")
        assert caption.one("b").text == chart.title
        assert [key.text for key in caption.all("span")] == [mark.key for mark in chart.marks if mark.key]
        paths = [path for path in figure.all("path") if path.attributes.get("class") != "grid"]
        assert len(paths) == len(chart.marks)


def test_the_bar_has_the_phase_of_every_push(run, tree):
    cells = [cell.attributes["title"] for cell in tree.one(class_="phases").all("i")]
    assert cells == columns(run.folder.path)["phase"][1:]


def test_the_script_is_given_every_state(run, data):
    poses, pictures = read_poses(run.folder.contours), read_pictures(run.folder.views)
    assert data["last"] == LAST
    assert [base64.b64decode(one) for one in data["pictures"]] == pictures
    for k in range(LAST + 1):
        shown = np.array([point.split(",") for point in data["contours"][k].split()], float)
        np.testing.assert_allclose(shown, poses.camera.to_picture(poses.contours[k]), atol=0.051)
        centre = np.array(data["centroids"][k].split(","), float)
        np.testing.assert_allclose(centre, poses.camera.to_picture(poses.centroids[k]), atol=0.051)
    assert data["paths"][0] is None
    ends = np.hstack([poses.camera.to_picture(poses.starts), poses.camera.to_picture(poses.ends)])
    np.testing.assert_allclose(data["paths"][1:], ends[1:], atol=0.051)


@pytest.mark.parametrize("k", [0, 1, 11, LAST])
def test_the_words_beside_the_view_are_those_of_the_push(run, data, tree, k):
    text = html_tree.read(data["texts"][k]).text
    position, angle, shape = in_digits(run, k)
    assert f"position {position} mm, angle {angle} deg, shape {shape}" in text
    told = columns(run.folder.path)
    if k:
        assert text.startswith(f"After push {k} of 12{told['phase'][k]}: xi {float(told['xi'][k]):+.3f}")
    else:
        assert text.startswith("Before the first push")
        assert tree.one(id="text").text == text
    if k < LAST:
        kappa, d = float(told["kappa"][k + 1]), 1e3 * float(told["d"][k + 1])
        assert f"Next, {told['phase'][k + 1]}: kappa {kappa:.3f}, d {d:.1f} mm" in text
    else:
        assert "Next" not in text
    expected = text.count("expected")
    assert expected == {0: 0, 1: 0, 11: 2, LAST: 1}[k], (
        "only pushes that a model chose were expected to do anything"
    )


def test_the_script_and_the_page_know_the_same_names(text, tree, data):
    script = (HERE / "page.js").read_text()
    assert set(re.findall(r"\brun\.(\w+)", script)) == set(data)
    rows = {"row"}
    ids = {node.attributes["id"] for node in tree.all() if "id" in node.attributes}
    assert set(re.findall(r'at\("(\w+)"', script)) - rows <= ids
    assert tree.one("input", type_="range").attributes["max"] == str(LAST)
    assert script in text


def test_settings_that_differ_from_the_defaults_stand_side_by_side(tree):
    header, *rows = tree.after("Settings that differ from the defaults").rows
    assert header == ["setting", "default", "this run"]
    assert ["acq.w", "2", "1"] in rows
    assert not any(row[0].startswith("record") for row in rows)


def test_figure_and_settings_open_when_asked_for(run, tmp_path):
    folder = shutil.copytree(run.folder.path, tmp_path / "run")
    (folder / "figures" / "run.png").write_bytes(b"picture")
    tree = html_tree.read(run_page.run_page(read(RunFolder(folder), "run"), Defaults()))
    figure, settings = tree.all("details")
    address = figure.one("img").attributes["src"]
    assert base64.b64decode(address.partition(",")[2]) == b"picture"
    assert settings.one("pre").text == (folder / "config.yaml").read_text()


def test_words_of_another_folder_are_text_not_html(run, tmp_path):
    folder = shutil.copytree(run.folder.path, tmp_path / "run")
    for name, old in (("pushes.csv", "explore"), ("pushes.csv", "exploit"), ("summary.json", "as asked")):
        path = folder / name
        path.write_text(path.read_text().replace(old, "<script>alert(1)</script>"))
    text = run_page.run_page(read(RunFolder(folder), "run"), Defaults())
    assert "alert(1)" in text
    assert "<script>alert" not in text
