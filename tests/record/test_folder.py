"""The run folder refuses what it must and never leaves half a file."""

import json
import os

import numpy as np
import pytest

from deformpush.record.folder import RESULTS, FolderError, RunFolder, next_part, parts
from deformpush.record.lock import Lock, held


def test_a_claimed_folder_holds_configuration_and_provenance(tmp_path):
    folder = RunFolder.create(tmp_path / "a" / "b", "seed: 3\n")
    assert list(folder.path.iterdir()) == []
    folder.claim()
    assert folder.config.read_text() == "seed: 3\n"
    assert json.loads((folder.path / "provenance.json").read_text())["packages"]["numpy"] == np.__version__
    assert {item.name for item in folder.path.iterdir()} == {
        ".lock",
        "config.yaml",
        "figures",
        "provenance.json",
    }


@pytest.mark.parametrize("name", RESULTS)
def test_a_folder_with_results_is_refused_and_left_alone(tmp_path, name):
    (tmp_path / name).write_text("old")
    with pytest.raises(
        FolderError, match=rf"^hydra\.run\.dir = .*already holds results \({name}\)"
    ) as caught:
        RunFolder.create(tmp_path, "seed: 3\n")
    assert "\n" not in str(caught.value)
    assert [(item.name, item.read_text()) for item in tmp_path.iterdir()] == [(name, "old")]


def test_what_hydra_writes_before_the_run_is_no_result(tmp_path):
    (tmp_path / ".hydra").mkdir()
    (tmp_path / "deformpush.log").touch()
    RunFolder.create(tmp_path, "").claim()
    assert (tmp_path / "config.yaml").exists()


def test_of_two_runs_one_gets_the_folder(tmp_path):
    first, second = RunFolder.create(tmp_path, "first"), RunFolder.create(tmp_path, "second")
    lock = first.claim()
    with pytest.raises(FolderError, match="another process is at work in this folder"):
        second.claim()
    lock.release()
    with pytest.raises(FolderError, match="already holds results"):
        second.claim()
    assert first.config.read_text() == "first"


def test_a_path_that_cannot_be_a_folder_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FolderError, match=r"^hydra\.run\.dir = .*cannot write there \(Not a directory\)$"):
        RunFolder.create(tmp_path / "file" / "run", "")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_no_write_permission_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(FolderError, match=r"cannot write there \(Permission denied\)"):
        RunFolder.create(tmp_path / "run", "")


def test_a_recording_has_its_parts_in_order(tmp_path):
    recording = tmp_path / "recording.rrd"
    assert (parts(recording), next_part(recording)) == ([], recording)
    names = ["recording.rrd", "recording-2.rrd", "recording-10.rrd"]
    for name in (*names, "other-3.rrd", "recording-x.rrd.tmp"):
        (tmp_path / name).touch()
    assert [path.name for path in parts(recording)] == names
    assert next_part(recording).name == "recording-11.rrd"


def test_a_resumption_is_noted_and_the_end_of_before_is_gone(tmp_path):
    folder = RunFolder.create(tmp_path, "")
    folder.claim().release()
    folder.summary.write_text("{}")
    for pushes in (3, 5):
        folder.note_resumption(pushes)
    found = json.loads((tmp_path / "provenance.json").read_text())
    assert [part["after"] for part in found["resumed"]] == [3, 5]
    assert "packages" in found
    assert not folder.summary.exists()


def test_json_is_strict(tmp_path):
    values = {"a": np.float64("nan"), "b": np.arange(2), "c": {"d": np.int64(3)}, "e": float("inf")}
    RunFolder(tmp_path).write_json("x.json", values)
    assert json.loads((tmp_path / "x.json").read_text()) == {"a": None, "b": [0, 1], "c": {"d": 3}, "e": None}


@pytest.mark.parametrize("name", [*RESULTS, ".lock", "deformpush.log", "recording-2.rrd", "figures/run.png"])
@pytest.mark.parametrize("there", [True, False], ids=["there", "nowhere"])
def test_nothing_is_written_through_a_link(name, there, tmp_path):
    """Whoever made the folder may have made it so that a run writes elsewhere."""
    elsewhere = tmp_path / "elsewhere"
    if there:
        elsewhere.write_text("mine")
    folder = RunFolder(tmp_path / "run")
    (folder.path / name).parent.mkdir(parents=True)
    (folder.path / name).symlink_to(elsewhere)
    with pytest.raises(FolderError, match=f"{name}: a symbolic link, and a run writes only") as caught:
        folder.lock()
    assert "\n" not in str(caught.value)
    if name in RESULTS:
        with pytest.raises(FolderError, match="already holds results"):
            RunFolder.create(folder.path, "")
    assert elsewhere.exists() == there
    assert not there or elsewhere.read_text() == "mine"
    assert sorted(folder.path.rglob("*")) == sorted(
        {folder.path / name, (folder.path / name).parent} - {folder.path}
    )


def test_a_lock_is_neither_taken_nor_looked_for_through_a_link(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / ".lock").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match="symbolic links"):
        Lock.take(folder)
    assert not held(folder)
    assert not (tmp_path / "elsewhere").exists()
    (folder / ".lock").unlink()
    os.mkfifo(folder / ".lock")
    assert not held(folder), "and a pipe is not waited for"


def test_what_a_killed_process_left_half_written_is_taken_away(tmp_path):
    folder = RunFolder.create(tmp_path, "")
    folder.claim().release()
    (tmp_path / ".contours.0a1b2c3d.tmp.npz").write_text("half")
    folder.note_resumption(3)
    assert not list(tmp_path.glob(".contours*"))
