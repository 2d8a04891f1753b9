"""compare.rrd: each run under its title, and lines, bands and stops with their values."""

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_pictures, read_poses
from deformpush.task import TERMS, TOTAL
from deformpush.viewer.comparison import Line, Sight, save
from tests.record.synthetic import CAMERA, SyntheticRun
from tests.viewer.recording import Contents, Recorded
from tests.viewer.test_bottom_view import closed, px

ERRORS = (*TERMS, TOTAL)
CURVES = {error.name: np.arange(5.0) + i for i, error in enumerate(ERRORS)}
SHORT = {name: curve[:3] * 2 for name, curve in CURVES.items()}
BAND = {name: (curve - 0.5, curve + 0.5) for name, curve in CURVES.items()}
STOPS = {"position": [20.0, 30.0], "angle": [7.0]}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    base = tmp_path_factory.mktemp("runs")
    return [
        Recorded.make(base / f"{n}", SyntheticRun(n, seed=n, mesh=False), scene=False, maps=False)
        for n in (2, 4)
    ]


@pytest.fixture(scope="module")
def contents(runs, tmp_path_factory):
    folders = [RunFolder(run.path.parent) for run in runs]
    sights = [
        Sight(f"run {i}", f"ended so {i}", read_poses(folder.contours), read_pictures(folder.views))
        for i, folder in enumerate(folders)
    ]
    lines = [Line("with band", palette.RUNS[0], CURVES, BAND), Line("single", palette.RUNS[1], SHORT)]
    path = tmp_path_factory.mktemp("compare") / "compare.rrd"
    save(path, sights, lines, STOPS, "# What *is* compared")
    return Contents(path)


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: error.name)
def test_lines_bands_and_stops_are_plotted(contents, error):
    path = f"/errors/{error.name}"
    np.testing.assert_array_equal(contents.curves(f"{path}/000")[:, 0], CURVES[error.name])
    np.testing.assert_array_equal(contents.curves(f"{path}/000/band").T, BAND[error.name])
    np.testing.assert_array_equal(contents.curves(f"{path}/001")[:, 0], SHORT[error.name])
    assert f"{path}/001/band" not in contents.entities
    assert contents.titles(f"{path}/000") == ["with band"]
    assert contents.titles(f"{path}/000/band") == ["with band"] * 2, "one entry in the legend"
    assert contents.titles(f"{path}/001") == ["single"]
    assert contents.colours(f"{path}/000", "SeriesLines:colors") == [palette.RUNS[0]]
    assert contents.colours(f"{path}/000/band", "SeriesLines:colors") == [palette.RUNS[0]] * 2
    stops = STOPS.get(error.name, [])
    for i, stop in enumerate(stops):
        np.testing.assert_array_equal(contents.curves(f"{path}/stop{i}")[:, 0], [stop] * 5)
        assert contents.titles(f"{path}/stop{i}") == ["stop"]
    assert f"{path}/stop{len(stops)}" not in contents.entities


def test_each_run_is_shown_as_its_own_recording_shows_it(contents, runs):
    for i, run in enumerate(runs):
        strips = contents.at(f"/runs/{i}/contour", "LineStrips2D:strips")
        trail = contents.at(f"/runs/{i}/trail", "LineStrips2D:strips")
        origins = contents.at(f"/runs/{i}/next_push/arrow", "Arrows2D:origins")
        blobs = contents.at(f"/runs/{i}/image", "EncodedImage:blob")
        assert list(strips) == list(trail) == list(blobs) == list(range(len(run.rows)))
        assert list(origins) == list(range(len(run.rows) - 1))
        for row in run.rows:
            np.testing.assert_allclose(strips[row.k][0], px(closed(row.view.seen.contour)), atol=1e-3)
            assert len(trail[row.k][0]) == row.k + 1
            if row.k:
                np.testing.assert_allclose(origins[row.k - 1], px(row.action.path.start[None]), atol=1e-3)
        goal = contents.fixed(f"/runs/{i}/goal", "LineStrips2D:strips")[0]
        np.testing.assert_allclose(goal, px(closed(run.info.target.outline)), atol=1e-3)
        ended = contents.at(f"/runs/{i}/ended", "Points2D:labels")
        assert ended == {len(run.rows) - 1: [f"ended so {i}"]}


def test_the_layout_names_runs_and_errors(contents):
    assert contents.columns() == [
        ["run 0", "run 1", "What is compared"],
        [error.label for error in ERRORS],
    ]
    shown = {view.name: view.origin for view in contents.views}
    assert [shown["run 0"], shown["run 1"]] == ["runs/0", "runs/1"]
    assert [shown[error.label] for error in ERRORS] == [f"errors/{error.name}" for error in ERRORS]
    assert contents.fixed("/about", "TextDocument:text") == ["# What *is* compared"]
    legends = [contents.view(error.label).properties["PlotLegend:visible"] for error in ERRORS]
    assert legends == [[True], [False], [False], [False]], "one is enough"


def test_all_runs_are_shown_with_the_same_part_of_the_table(contents, runs):
    first, second = (contents.view(f"run {i}").properties["VisualBounds2D:range"][0] for i in (0, 1))
    assert first == second
    everywhere = px(np.vstack([row.view.seen.contour for run in runs for row in run.rows]))
    for axis, name in enumerate(("x_range", "y_range")):
        low, high = first[name]
        assert max(0, low) <= everywhere[:, axis].clip(0, CAMERA.pixels).min()
        assert everywhere[:, axis].clip(0, CAMERA.pixels).max() <= high


def test_without_pictures_the_errors_are_compared_all_the_same(tmp_path):
    save(tmp_path / "compare.rrd", [], [Line("one", palette.RUNS[0], CURVES)], {}, "about")
    contents = Contents(tmp_path / "compare.rrd")
    assert contents.columns() == [["What is compared"], [error.label for error in ERRORS]]
