"""A run that was stopped anywhere ends as if it had not been."""

import json
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deformpush.errors import UserError
from deformpush.experiment import run
from deformpush.experiment.repeat import DivergedError
from deformpush.experiment.run import make_run, resume
from deformpush.record.lock import Lock, held
from deformpush.record.poses import read_pictures, read_poses
from deformpush.record.summary import Summary
from deformpush.record.table import read
from deformpush.worlds.toy import ToyWorld
from tests.faults import ended_by, moments
from tests.setups import setup

TOY = ["world=toy", "robot=tool", "record=off", "stop=strict", "task.goal.offset=[0,0.3]"]
RUN = setup(*TOY, "max_pushes=16", "seed=3")
GENTLE = ["acquisition=safe_lcb", "acq.limit=0.1"]
TIMES = ["step_s", "render_s", "decide_s", "record_s"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The run without an interruption."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    make_run(RUN, folder)
    return folder


@pytest.fixture
def begun(tmp_path, whole):
    """The same run as a kill after push 12 left it."""
    return cut(whole, tmp_path / "run", 12)


def cut(whole: Path, folder: Path, pushes: int) -> Path:
    """What a kill after so many pushes leaves, but for a checkpoint."""
    shutil.copytree(whole, folder)
    for name in ("summary.json", "checkpoint.npz"):
        (folder / name).unlink()
    rows = (folder / "pushes.csv").read_text().splitlines(keepends=True)
    (folder / "pushes.csv").write_text("".join(rows[: pushes + 2]))
    return folder


def ended(summary: Summary | None) -> bool:
    """Whether a run was brought to its end now."""
    return summary is not None and summary.status == "budget"


def same(folder: Path, other: Path) -> None:
    """The two runs made the same pushes with the same outcomes, to the bit."""
    a, b = (read(path / "pushes.csv").drop(columns=TIMES) for path in (folder, other))
    assert a.equals(b)
    one, two = (read_poses(path / "contours.npz") for path in (folder, other))
    np.testing.assert_array_equal(one.contours, two.contours)
    np.testing.assert_array_equal(one.starts, two.starts)
    assert read_pictures(folder / "views.npz") == read_pictures(other / "views.npz")
    ends = [json.loads((path / "summary.json").read_text()) for path in (folder, other)]
    for name in ("status", "reason", "pushes", "e_T", "steps"):
        assert ends[0][name] == ends[1][name]


@pytest.mark.parametrize("pushes", [0, 3, 10, 12, 16])
def test_a_run_goes_on_after_any_push(pushes, tmp_path, whole):
    folder = cut(whole, tmp_path / "run", pushes)
    assert ended(resume(folder))
    same(folder, whole)
    assert json.loads((folder / "summary.json").read_text())["resumed"] == pushes
    assert not held(folder)


@pytest.mark.parametrize(("row", "delay"), moments(6, 15))
def test_a_killed_run_is_continued_to_the_bit(row, delay, tmp_path, whole):
    if ended_by(signal.SIGKILL, RUN, tmp_path / "run", row, delay):
        assert not held(tmp_path / "run")
        assert ended(resume(tmp_path / "run"))
    same(tmp_path / "run", whole)


@pytest.mark.slow
@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("row", "delay"), moments(20, 15, seed=1))
def test_twenty_killed_runs_are_continued_to_the_bit(row, delay, sign, tmp_path, whole):
    if ended_by(sign, RUN, tmp_path / "run", row, delay):
        assert ended(resume(tmp_path / "run"))
    same(tmp_path / "run", whole)


@pytest.mark.slow
@pytest.mark.parametrize(
    "method", [["optimizer=abo"], ["optimizer=abo_motion", *GENTLE]], ids=["paper", "gentle"]
)
def test_a_soft_object_that_was_killed_under_is_pushed_on_to_the_bit(method, tmp_path):
    """In Bullet, whose soft body can only be brought back by making its pushes again."""
    made = setup("robot=tool", "record=light", "max_pushes=12", "seed=3", *method)
    make_run(made, tmp_path / "whole")
    for n, (row, delay) in enumerate(moments(2, 12, seed=2)):
        folder = tmp_path / f"run-{n}"
        if ended_by(signal.SIGKILL, made, folder, row, 40 * delay):  # anywhere in a push of a second
            assert ended(resume(folder))
        same(folder, tmp_path / "whole")


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_stopped_run_says_so_and_is_continued(sign, tmp_path, whole):
    ended_by(sign, RUN, tmp_path / "run", 5, 0.0)
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["status"] == "interrupted"
    assert ended(resume(tmp_path / "run"))
    same(tmp_path / "run", whole)


def test_a_run_killed_twice_is_continued_twice(tmp_path, whole):
    folder = cut(whole, tmp_path / "run", 13)
    assert ended(resume(folder))
    again = cut(folder, tmp_path / "again", 14)
    assert ended(resume(again))
    same(again, whole)
    parts = json.loads((again / "provenance.json").read_text())["resumed"]
    assert [part["after"] for part in parts] == [13, 14]


def test_with_a_checkpoint_the_optimizer_need_not_think_again(tmp_path, whole, monkeypatch):
    folder = cut(whole, tmp_path / "run", 16)
    shutil.copy(whole / "checkpoint.npz", folder)
    monkeypatch.setattr("deformpush.optimizer.abo.ABO.ask", lambda *_: pytest.fail("it was asked"))
    assert ended(resume(folder))
    same(folder, whole)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut", None], ids=["empty", "foreign", "truncated"])
def test_a_damaged_checkpoint_costs_time_and_nothing_else(content, begun, whole):
    good = (whole / "checkpoint.npz").read_bytes()
    (begun / "checkpoint.npz").write_bytes(good[: len(good) // 2] if content is None else content)
    assert ended(resume(begun))
    same(begun, whole)


def test_a_checkpoint_ahead_of_the_table_is_not_used(begun, whole):
    shutil.copy(whole / "checkpoint.npz", begun)
    assert ended(resume(begun))
    same(begun, whole)


def test_a_checkpoint_with_a_flipped_bit_is_not_used(begun, whole):
    data = bytearray((whole / "checkpoint.npz").read_bytes())
    data[len(data) // 2] ^= 4
    (begun / "checkpoint.npz").write_bytes(bytes(data))
    assert ended(resume(begun))
    same(begun, whole)


@pytest.mark.parametrize("name", ["contours.npz", "views.npz", "provenance.json"])
@pytest.mark.parametrize("harm", [lambda file: file.unlink(), lambda file: file.write_bytes(b"\x00cut")])
def test_files_beside_the_table_are_made_again(name, harm, begun, whole):
    harm(begun / name)
    assert ended(resume(begun))
    same(begun, whole)


def test_a_row_that_was_cut_is_made_again(begun, whole):
    with (begun / "pushes.csv").open("ab") as file:
        file.write(b"13,exploit,0.123")
    assert ended(resume(begun))
    same(begun, whole)


def test_a_run_killed_before_its_first_row_begins_anew(tmp_path, whole):
    folder = cut(whole, tmp_path / "run", 0)
    (folder / "pushes.csv").unlink()
    assert ended(resume(folder))
    same(folder, whole)


def test_a_finished_run_is_left_alone(whole, capsys):
    before = {file.name: file.stat().st_mtime_ns for file in whole.iterdir()}
    assert resume(whole) is None
    assert "nothing to resume, it ended: budget after 16 pushes" in capsys.readouterr().out
    assert {file.name: file.stat().st_mtime_ns for file in whole.iterdir()} == before


def test_two_processes_do_not_work_in_one_folder(begun):
    lock = Lock.take(begun)
    with pytest.raises(UserError, match="another process is at work in this folder"):
        resume(begun)
    lock.release()
    assert ended(resume(begun))


def test_a_world_that_does_not_repeat_itself_is_not_continued(begun, monkeypatch):
    before = {file.name: file.read_bytes() for file in begun.iterdir() if file.is_file()}
    whole = ToyWorld.push

    def push(self, path):
        outcome = whole(self, path)
        self.theta += 1e-3  # enough that some pixel of every picture changes
        return outcome

    monkeypatch.setattr(ToyWorld, "push", push)
    with pytest.raises(DivergedError, match=r"push \d+ does not repeat itself: .* and was ") as caught:
        resume(begun)
    assert caught.value.exit_code == 1
    assert {file.name: file.read_bytes() for file in begun.iterdir() if file.is_file()} == before


def test_an_optimizer_that_decides_otherwise_is_noticed(begun, monkeypatch):
    other_weight(monkeypatch, 5.0)
    with pytest.raises(
        DivergedError, match=r"push 1[12] does not .*: the optimizer now chooses kappa = .*it pushed"
    ):
        resume(begun)


def other_weight(monkeypatch, w):
    """Let runs that are taken up be decided with another weight than their config.yaml says."""
    whole = run.build_optimizer

    def build(made):
        return whole(replace(made, acq=replace(made.acq, w=w)))

    monkeypatch.setattr(run, "build_optimizer", build)


def test_a_table_of_an_older_version_gets_no_rows_of_this_one(begun):
    rows = (begun / "pushes.csv").read_text().splitlines()
    (begun / "pushes.csv").write_text("".join(",".join(row.split(",")[:23]) + "\n" for row in rows))
    with pytest.raises(UserError, match="of an older version, whose runs can only be looked at"):
        resume(begun)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("k,nonsense\n", "not a table of pushes"),
        ("\x00\x01", "not a table of pushes"),
    ],
)
def test_a_damaged_table_is_one_line(text, message, begun):
    (begun / "pushes.csv").write_text(text)
    with pytest.raises(UserError, match=message) as caught:
        resume(begun)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text.replace("stop_when: all", ""), r"config.yaml: task.stop_when: missing"),
        (lambda text: text.replace("stop_when:", "stop_if:"), r"config.yaml: task.stop_if: unknown"),
        (lambda text: "seed: 3\n", r"config.yaml: .*missing or unknown; of another version"),
        (lambda text: "a: [", r"config.yaml: line 2: did not find expected"),
    ],
)
def test_a_configuration_of_another_version_is_one_line(change, message, begun):
    file = begun / "config.yaml"
    file.write_text(change(file.read_text()))
    with pytest.raises(UserError, match=message) as caught:
        resume(begun)
    assert "\n" not in str(caught.value)


def test_a_folder_that_holds_no_run_is_one_line(tmp_path):
    with pytest.raises(UserError, match=r"no config\.yaml, so there is no run to take up"):
        resume(tmp_path)
    with pytest.raises(UserError, match="no such folder"):
        resume(tmp_path / "nowhere")
