"""The verb `compare`, from the command line to its files."""

import csv
import shutil

import cv2
import numpy as np
import pytest
from rerun.chunk import RrdReader

from deformpush.cli import compare
from deformpush.errors import UserError
from deformpush.viewer.headless import NEEDS, has_driver, screenshot
from tests.study.folders import finished


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
    assert "differing: acq.w, seed" in out
    assert err == "skipped acq.w=1,seed=2: no summary.json: it still runs, or was killed\n"
    with (study / "compare.csv").open(newline="") as file:
        assert [row["pushes"] for row in csv.DictReader(file)] == ["12", "15", "4", "11"]
    assert cv2.imread(str(study / "compare.png")).std() > 10
    assert sorted(path.name for path in study.iterdir() if path.is_file()) == sorted(compare.FILES)


def test_the_recording_lays_runs_of_any_length_over_each_other(study):
    compare.main([str(study)])
    found: dict[str, int] = {}
    for chunk in RrdReader(str(study / "compare.rrd")).stream().to_chunks():
        batch = chunk.to_record_batch()
        if "push" in batch.schema.names:
            path = str(chunk.entity_path)
            found[path] = found.get(path, 0) + batch.num_rows
    assert [found[f"/errors/position/{i:03d}"] for i in range(4)] == [13, 16, 5, 12]
    assert sorted(found[f"/runs/{i}/contour"] for i in range(4)) == [5, 12, 13, 16]


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
    entities = {
        str(chunk.entity_path) for chunk in RrdReader(str(tmp_path / "compare.rrd")).stream().to_chunks()
    }
    assert {path for path in entities if path.startswith("/errors/total")} == {
        f"/errors/total/{i:03d}{band}" for i in range(2) for band in ("", "/band")
    }
    assert sum(path.endswith("/image") for path in entities) == 6


@pytest.mark.screen
@pytest.mark.skipif(not has_driver(), reason=f"the viewer {NEEDS}")
def test_no_view_of_the_comparison_reports_an_error(study, tmp_path):
    compare.main([str(study)])
    picture = tmp_path / "compare.png"
    assert screenshot([study / "compare.rrd"], picture, 4) == []
    seen = cv2.imread(str(picture))
    assert seen.shape == (900, 1600, 3)
    assert np.std(seen) > 20
