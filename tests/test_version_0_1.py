"""A folder that version 0.1 made (tests/data/run_0_1, record=off): it can be looked at, and not taken up."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import deformpush
from deformpush.cli import compare, replay, report, resume, status, video, view
from deformpush.errors import UserError
from deformpush.experiment.run import make_run
from deformpush.record.finished import read
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_poses
from deformpush.record.table import TIMES
from tests.setups import setup

MADE = Path(__file__).resolve().parent / "data" / "run_0_1"


@pytest.fixture
def old(tmp_path):
    """A copy, so that nothing is written into the checkout."""
    return shutil.copytree(MADE, tmp_path / "old")


@pytest.fixture
def begun(old):
    """The same run as a kill would have left it."""
    (old / "summary.json").unlink()
    return old


def test_it_is_small():
    assert sum(file.stat().st_size for file in MADE.iterdir()) < 300_000


def test_it_is_read_like_one_of_today(old):
    run = read(RunFolder(old), "old")
    assert (run.summary.status, run.summary.pushes, run.options["sim"]) == ("budget", 12, "toy")
    assert run.summary.errors["e_gamma"] == run.columns["e_gamma"][-1]
    poses = read_poses(RunFolder(old).contours)
    assert poses.contours.shape == (13, 128, 2)
    apart = np.linalg.norm(poses.centroids - poses.goal_c, axis=1)
    np.testing.assert_allclose(apart, run.columns["position_error_m"], atol=1e-9)


def test_it_is_loaded_like_one_of_today(old):
    run = deformpush.load(old)
    assert (run.summary.status, len(run.pushes), run.contours.shape) == ("budget", 13, (13, 128, 2))
    assert run.figure().axes


def test_the_same_settings_still_make_the_same_initial_samples(old, tmp_path):
    """As far as today's rounding goes (kappa to 1e-5). What the model chooses may change with the version."""
    of_then = ("world=toy", "robot=tool", "contour.angle=pca", "record=off", "max_pushes=10")
    make_run(setup(*of_then), tmp_path / "new")
    then, now = (read(RunFolder(folder), "run").columns for folder in (old, tmp_path / "new"))
    assert list(then) == list(now)
    for name in set(then) - {"phase", *TIMES}:
        np.testing.assert_allclose(now[name], then[name][:11], rtol=1e-5, atol=1e-5, err_msg=name)
    assert now["phase"] == then["phase"][:11]


def test_it_can_be_compared(old, tmp_path, capsys):
    assert compare.main([str(old), "--out", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[:3] == ["rect", "error", "lcb"]
    assert {file.name for file in (tmp_path / "out").iterdir()} == {
        "compare.csv",
        "compare.png",
        "compare.rrd",
    }


def test_it_can_be_compared_with_one_of_today(old, tmp_path, capsys):
    new = setup("world=toy", "robot=tool", "record=off", "max_pushes=11")
    make_run(new, tmp_path / "new")
    capsys.readouterr()
    assert compare.main([str(old), str(tmp_path / "new"), "--out", str(tmp_path / "out")]) == 0
    assert "max_pushes" in capsys.readouterr().out
    assert (tmp_path / "out" / "compare.csv").read_text().count("\n") == 3


def test_it_can_be_reported(old, tmp_path):
    assert report.main([str(old), "--out", str(tmp_path / "page.html")]) == 0
    assert "rect" in (tmp_path / "page.html").read_text()


def test_it_can_be_told_of(old, capsys):
    assert status.main([str(old)]) == 0
    assert capsys.readouterr().out.splitlines()[1].split() == ["done", "1", "1", "spent", "the", "budget"]


def test_a_film_of_it_can_be_made(old, tmp_path):
    assert video.main([str(old), "--out", str(tmp_path / "film.mp4")]) == 0
    assert (tmp_path / "film.mp4").stat().st_size > 10_000


def test_without_a_recording_there_is_nothing_to_view(old):
    with pytest.raises(UserError, match=r"old: holds no recording\.rrd; record=off writes none") as caught:
        view.main([str(old)])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("verb", [resume, replay])
def test_it_is_not_taken_up(verb, begun):
    before = {file.name: file.read_bytes() for file in begun.iterdir() if file.is_file()}
    with pytest.raises(UserError) as caught:
        verb.main([str(begun)])
    line = "of version 0.1; compare, report and view take it, resume and replay do not"
    assert str(caught.value) == f"{begun / 'config.yaml'}: {line}"
    assert caught.value.exit_code == 2
    assert {file.name: file.read_bytes() for file in begun.iterdir() if file.is_file()} == before


def test_one_that_has_ended_has_nothing_to_resume(old, capsys):
    assert resume.main([str(old)]) == 0
    assert "nothing to resume, it ended: budget after 12 pushes" in capsys.readouterr().out
