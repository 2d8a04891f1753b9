"""The page of a sweep: variants, charts, last views and runs, each as its folder tells."""

import shutil

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.record.poses import read_poses
from deformpush.study import sweep_page
from deformpush.study.chart import css
from deformpush.study.find_runs import find_runs
from deformpush.study.tables import run_rows, variant_rows
from deformpush.study.variants import BAND_CAPTION, differing, variants
from deformpush.task import TERMS
from tests.study import html_tree
from tests.study.folders import finished, numbers

NAMES = [f"acq.w={w},seed={seed}" for w in (1, 2) for seed in (0, 1)]


@pytest.fixture(scope="module")
def found(sweep, tmp_path_factory):
    """The runs of a sweep, one of which never ended."""
    folder = tmp_path_factory.mktemp("page") / "sweep"
    shutil.copytree(sweep, folder)
    shutil.copytree(folder / NAMES[0], folder / "acq.w=1,seed=2")
    (folder / "acq.w=1,seed=2" / "summary.json").unlink()
    return find_runs([folder])


@pytest.fixture(scope="module")
def groups(found):
    return variants(found.runs, differing(found.runs))


@pytest.fixture(scope="module")
def tree(found):
    return html_tree.read(sweep_page.sweep_page("a <sweep>", found))


def test_the_head_counts_runs_and_pushes(tree):
    assert tree.one("title").text == tree.one("h1").text == "a <sweep>"
    boxes = [(box.one("span").text, box.one("b").text) for box in tree.one(class_="facts").all("div")]
    assert boxes == [
        ("runs", "4"),
        ("reached the goal", "3 of 4"),
        ("variants", "2"),
        ("pushes", str(12 + 15 + 4 + 11)),
        ("time in all", "0 min"),
    ]


def test_the_tables_have_every_variant_run_and_setting(tree, found, groups):
    assert tree.after("Variants").rows == variant_rows(groups)
    assert tree.after("Runs").rows == run_rows(found.runs, differing(found.runs))
    assert [row[-1] for row in tree.after("Runs").rows[1:]] == NAMES
    assert tree.after("Settings that differ").rows == [
        ["setting", "values"],
        ["acq.w", "1, 2"],
        ["seed", "0, 1"],
    ]
    reason = "no summary.json: it still runs, or was killed"
    assert tree.after("Left out").rows == [["run", "reason"], ["acq.w=1,seed=2", reason]]


def test_the_charts_show_each_variant(found, groups):
    charts = sweep_page.charts(groups, found.runs)
    assert [chart.title for chart in charts] == [*(term.label for term in TERMS), "runs at the goal (%)"]
    for chart, term, stop in zip(charts, TERMS, (20.0, 7.0, 0.15), strict=False):
        *pairs, level = chart.marks
        assert [(mark.kind, mark.key) for mark in pairs] == [
            ("area", ""),
            ("line", "acq.w 1"),
            ("area", ""),
            ("line", "acq.w 2"),
        ]
        assert [mark.colour for mark in pairs] == [palette.RUNS[i] for i in (0, 0, 1, 1)]
        for i, variant in enumerate(groups):
            curves = [np.abs(numbers(run.folder.path, term.column)) * term.scale for run in variant.runs]
            one, other = sorted(curves, key=len)
            one = np.r_[one, [one[-1]] * (len(other) - len(one))]
            low, high = np.minimum(one, other), np.maximum(one, other)
            edges = [*(low + (high - low) / 4), *(high - (high - low) / 4)[::-1]]
            np.testing.assert_allclose(pairs[2 * i].values, edges)
            np.testing.assert_allclose(pairs[2 * i + 1].values, (one + other) / 2)
        assert (level.key, level.colour) == (f"stop {stop:.3g}", palette.STOP)
        assert level.values == pytest.approx([stop] * 16)
    for mark, steps in zip(charts[-1].marks, ({12: 50}, {4: 50, 11: 100}), strict=True):
        share = np.array([max([0, *(v for at, v in steps.items() if at <= k)]) for k in range(16)])
        np.testing.assert_array_equal(mark.values[::2], share)


def test_every_chart_is_on_the_page_with_every_mark(tree, found, groups):
    figures = tree.all("figure", class_="chart")
    for figure, chart in zip(figures, sweep_page.charts(groups, found.runs), strict=True):
        caption = figure.one("figcaption")
        assert caption.one("b").text == chart.title
        keys = [key.text for key in caption.all("span")]
        assert keys == [mark.key for mark in chart.marks if mark.key]
        paths = [path for path in figure.all("path") if path.attributes.get("class") != "grid"]
        assert len(paths) == len(chart.marks)
    assert BAND_CAPTION[1:] in tree.one("main").text


def test_the_last_view_of_each_run_is_shown_in_turn(tree, found):
    figures = tree.after("Where they ended").all("figure")
    ends = ["reached, 12 pushes", "reached, 4 pushes", "budget, 15 pushes", "reached, 11 pushes"]
    order = [NAMES[i] for i in (0, 2, 1, 3)]
    titles = [name.replace("=", " ").replace(",", ", ") for name in order]
    assert [figure.one("figcaption").text for figure in figures] == [
        f"{title}: {end}" for title, end in zip(titles, ends, strict=True)
    ]
    runs = {run.name: run for run in found.runs}
    for figure, name in zip(figures, order, strict=True):
        poses = read_poses(runs[name].folder.contours)
        contour = figure.one("polygon", stroke=css(palette.CONTOUR))
        shown = np.array([point.split(",") for point in contour.attributes["points"].split()], float)
        np.testing.assert_allclose(shown, poses.camera.to_picture(poses.contours[-1]), atol=0.051)
        assert len(figure.all("image")) == 1
    assert len({figure.one("svg").attributes["viewbox"] for figure in figures}) == 1, (
        "the same part of the table"
    )


def test_a_run_without_pictures_is_left_out_of_the_views(found, tmp_path):
    folder = shutil.copytree(found.runs[0].folder.path.parent, tmp_path / "sweep")
    (folder / NAMES[1] / "views.npz").write_bytes(b"")
    tree = html_tree.read(sweep_page.sweep_page("sweep", find_runs([folder])))
    assert len(tree.after("Where they ended").all("figure")) == 3
    assert len(tree.after("Runs").rows) == 5


def test_one_run_differs_in_nothing(tmp_path):
    finished(tmp_path / "run", 2)
    tree = html_tree.read(sweep_page.sweep_page("sweep", find_runs([tmp_path])))
    assert tree.after("Settings that differ").text == "None."


def test_words_of_another_folder_are_text_not_html(tmp_path):
    finished(tmp_path / "<script>alert(1)<", 2)
    text = sweep_page.sweep_page("<script>sweep", find_runs([tmp_path]))
    assert text.count("&lt;script&gt;alert(1)&lt;") == 2, "below its view, and in the table"
    assert "<script>" not in text
