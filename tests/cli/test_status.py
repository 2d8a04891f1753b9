"""The verb `status`: what it says of runs that lie anywhere; tests/experiment/test_sweep.py has sweeps."""

import shutil

import pytest

from deformpush.cli import status
from deformpush.errors import UserError
from tests.study.folders import finished


@pytest.fixture
def runs(tmp_path):
    """Four runs: one at the goal, one failed, two killed, of which one had only begun."""
    finished(tmp_path / "done", 3)
    finished(tmp_path / "failed", 2, status="failed")
    killed = shutil.copytree(tmp_path / "done", tmp_path / "killed")
    (killed / "summary.json").unlink()
    (tmp_path / "begun").mkdir()
    (tmp_path / "begun" / "config.yaml").touch()
    return tmp_path


def test_every_run_is_counted_and_the_bad_ones_are_explained(runs, capsys):
    assert status.main([str(runs)]) == 0
    first, *lines = capsys.readouterr().out.splitlines()
    assert first == f"{runs}: 4 runs"
    assert [line.split()[:2] for line in lines[:3]] == [["done", "1"], ["interrupted", "2"], ["failed", "1"]]
    assert lines[0].endswith("1 reached the goal")
    assert lines[3].split()[:2] == ["time", "left"]
    assert lines[4:] == [
        "interrupted: begun: no summary.json: it was killed",
        "failed: failed: as asked",
        "interrupted: killed: no summary.json: it was killed",
    ]
    assert not (runs / "sweep.csv").exists(), "it is no sweep"


def test_a_long_list_of_reasons_is_cut(tmp_path, capsys):
    for i in range(status.MOST + 2):
        finished(tmp_path / f"run{i}", 1, status="failed")
    status.main([str(tmp_path)])
    lines = capsys.readouterr().out.splitlines()
    assert sum(line.startswith("failed: run") for line in lines) == status.MOST
    assert lines[-1] == "... and 2 more"


def test_a_folder_without_runs_is_refused(tmp_path):
    with pytest.raises(UserError, match="nowhere: no such folder"):
        status.main(["nowhere"])
    with pytest.raises(UserError, match="holds no runs"):
        status.main([str(tmp_path)])
