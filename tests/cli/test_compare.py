"""The verb `compare`, from the command line to its files; `cli.output`, which guards them, is tested here."""

import csv
import shutil

import cv2
import numpy as np
import pytest

from deformpush.cli import compare
from deformpush.errors import UserError
from deformpush.record import palette
from deformpush.study import compare_figure
from deformpush.study.find_runs import find_runs
from deformpush.study.variants import differing, variants
from deformpush.task import TERMS, TOTAL
from deformpush.viewer.headless import NEEDS, has_driver, screenshot
from tests.study.folders import finished, numbers
from tests.viewer.recording import Contents


@pytest.fixture
def study(sweep, tmp_path):
    """A sweep to write into, one of whose runs was killed."""
    folder = shutil.copytree(sweep, tmp_path / "sweep")
    shutil.copytree(folder / "acq.w=1,seed=0", folder / "acq.w=1,seed=2")
    (folder / "acq.w=1,seed=2" / "summary.json").unlink()
    return folder


def test_a_sweep_is_compared_in_its_own_folder(study, capsys):
    assert compare.main([str(study)]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert [line.split()[-1] for line in lines[1:5]] == [
        f"acq.w={w},seed={s}" for w in (1, 2) for s in (0, 1)
    ]
    assert [line.split()[:5] for line in lines[7:9]] == [
        ["acq.w", "1", "2", "1", "0"],
        ["acq.w", "2", "2", "2", "1"],
    ]
    assert "differing: acq.w, seed" in lines
    assert lines[-1].startswith(f"written:   {study / 'compare.csv'}, compare.png, compare.rrd (rerun ")
    assert err == "skipped acq.w=1,seed=2: no summary.json: it still runs, or was killed\n"
    with (study / "compare.csv").open(newline="") as file:
        assert [row["pushes"] for row in csv.DictReader(file)] == ["12", "15", "4", "11"]
    runs = find_runs([study]).runs
    assert (study / "compare.png").read_bytes() == compare_figure.draw(variants(runs, differing(runs)))
    assert sorted(path.name for path in study.iterdir() if path.is_file()) == sorted(compare.FILES)


def test_the_recording_lays_runs_of_any_length_over_each_other(study):
    compare.main([str(study)])
    contents, runs = Contents(study / "compare.rrd"), find_runs([study]).runs
    for quantity in (*TERMS, TOTAL):
        for i, run in enumerate(runs):
            values = np.abs(numbers(run.folder.path, quantity.column)) * quantity.scale
            entity = f"/errors/{quantity.name}/{i:03d}"
            np.testing.assert_allclose(contents.curves(entity), values[:, None])
            assert contents.times(entity, "push") == list(range(len(values)))
            assert contents.titles(entity) == [f"acq.w {1 + i // 2}"]
            assert contents.colours(entity, "SeriesLines:colors") == [palette.RUNS[i // 2]]
    for term, stop in zip(TERMS, (20.0, 7.0, 0.15), strict=True):
        np.testing.assert_allclose(contents.curves(f"/errors/{term.name}/stop0"), np.full((16, 1), stop))
    states = [len(contents.times(f"/runs/{i}/contour", "push")) for i in range(4)]
    assert states == [13, 5, 16, 12], "in turn one of each variant"


def test_nothing_is_overwritten_unasked(study):
    (study / "compare.png").write_text("mine")
    with pytest.raises(UserError, match=r"compare\.png exists already; --overwrite replaces it"):
        compare.main([str(study)])
    assert (study / "compare.png").read_text() == "mine"
    assert not (study / "compare.csv").exists()
    assert compare.main([str(study), "--overwrite"]) == 0
    assert (study / "compare.png").stat().st_size > 1000


def test_runs_from_several_places_are_compared_here_or_where_asked(study, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pair = [str(study / "acq.w=1,seed=0"), str(study / "acq.w=2,seed=1")]
    assert compare.main([*pair, "--out", "there/deep"]) == 0
    assert (tmp_path / "there" / "deep" / "compare.rrd").exists()
    assert compare.main(pair) == 0
    assert (tmp_path / "compare.rrd").exists()


def test_many_runs_become_a_line_a_variant(tmp_path):
    for seed in range(7):
        for w in (1.0, 2.0):
            finished(tmp_path / f"w={w},seed={seed}", 2 + seed, seed=seed, w=w)
    compare.main([str(tmp_path)])
    contents, runs = Contents(tmp_path / "compare.rrd"), find_runs([tmp_path]).runs
    assert {path for path in contents.entities if path.startswith("/errors/total")} == {
        f"/errors/total/{i:03d}{band}" for i in range(2) for band in ("", "/band")
    }
    for i, variant in enumerate(variants(runs, differing(runs))):
        for quantity in (*TERMS, TOTAL):
            band, entity = variant.band(quantity), f"/errors/{quantity.name}/{i:03d}"
            np.testing.assert_allclose(contents.curves(entity)[:, 0], band.middle)
            edges = np.column_stack([band.low, band.high])
            np.testing.assert_allclose(contents.curves(f"{entity}/band"), edges)
            assert contents.titles(entity) == [f"acq.w {1 + i} (7)"]
    assert sum(path.endswith("/image") for path in contents.entities) == 6


@pytest.mark.screen
@pytest.mark.skipif(not has_driver(), reason=f"the viewer {NEEDS}")
def test_no_view_of_the_comparison_reports_an_error(study, tmp_path):
    compare.main([str(study)])
    picture = tmp_path / "compare.png"
    assert screenshot([study / "compare.rrd"], picture, 4) == []
    seen = cv2.imread(str(picture))
    assert seen.shape == (900, 1600, 3)
    assert np.std(seen) > 20
