"""A run folder from anywhere: pipes are not waited for, links not followed, huge files not read.

What each reader does with one strange file is tested in tests/record; here, whole commands.
"""

import base64
import contextlib
import io
import json
import os
import shutil
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deformpush.cli import report, status, video
from deformpush.cli.replay import main as replay
from deformpush.errors import UserError
from deformpush.experiment.run import resume
from deformpush.experiment.sweep import manifest
from deformpush.record import table
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_poses
from deformpush.study import run_data, run_figure
from deformpush.study.find_runs import find_runs
from tests.experiment.test_resume import cut, ended, same
from tests.experiment.test_resume import whole as whole_run

whole = whole_run


def pipe(file: Path) -> None:
    os.mkfifo(file)


def link(file: Path) -> None:
    elsewhere = file.parents[1] / "elsewhere"
    elsewhere.write_text("mine")
    file.symlink_to(elsewhere)


def sparse(file: Path) -> None:
    """A gigabyte and a half that takes no room on the disk."""
    with file.open("wb") as handle:
        handle.truncate(1_500_000_000)


def bomb(file: Path) -> None:
    """A small file that unpacks to four gigabytes, of a header that speaks of terabytes."""
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (20000000, 1000000), }".ljust(117) + b"\n"
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("contours", "data", "ends", "json", "k"):
            whole = b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + header + bytes(4_000_000)
            archive.writestr(f"{name}.npy", whole)
    file.write_bytes(content.getvalue())


STRANGE = {"pipe": pipe, "link": link, "folder": Path.mkdir, "sparse": sparse, "bomb": bomb}
READ = ("config.yaml", "provenance.json", "pushes.csv", "contours.npz", "views.npz", "summary.json")
pytestmark = pytest.mark.timeout(60)


def harmed(run: Path, name: str, kind: str) -> Path:
    (run / name).unlink(missing_ok=True)
    STRANGE[kind](run / name)
    return run


def said(command: Callable[[], object]) -> str:
    """What a command complains of: nothing, or one line."""
    with contextlib.suppress(UserError):
        command()
        return ""
    with pytest.raises(UserError) as caught:
        command()
    assert "\n" not in caught.value.line
    return str(caught.value)


@pytest.mark.parametrize("kind", STRANGE)
@pytest.mark.parametrize("name", READ)
def test_a_strange_file_in_a_finished_run_is_one_line(name, kind, tmp_path, whole):
    run = harmed(Path(shutil.copytree(whole, tmp_path / "sweep" / "run")), name, kind)
    found = find_runs([shutil.copytree(whole, tmp_path / "sweep" / "good").parent])
    if name in ("config.yaml", "pushes.csv", "summary.json"):
        ((skipped, why),) = found.skipped
        assert skipped == "run"
        assert name in why
        assert "\n" not in why
    else:
        assert len(found.runs) == 2
    if name in ("pushes.csv", "contours.npz", "views.npz"):
        with pytest.raises((OSError, ValueError), match=name):
            run_data.read(RunFolder(run))


@pytest.mark.parametrize("name", ["config.yaml", "pushes.csv", "contours.npz", "views.npz", "summary.json"])
def test_no_verb_waits_for_a_pipe(name, tmp_path, whole, capsys):
    run = harmed(Path(shutil.copytree(whole, tmp_path / "sweep" / "run")), name, "pipe")
    assert name in said(lambda: video.main([str(run), "--out", str(tmp_path / "a.mp4")]))
    assert name in said(lambda: report.main([str(run), "--out", str(tmp_path / "report.html")]))
    assert status.main([str(tmp_path / "sweep")]) == 0
    assert not list(tmp_path.glob("*.*"))


KILLED = ("provenance.json", "pushes.csv", "contours.npz", "views.npz", "summary.json")


@pytest.mark.parametrize("kind", STRANGE)
@pytest.mark.parametrize("name", [*KILLED, "states.bin", "checkpoint.npz", "forecasts.csv", "recording.rrd"])
def test_a_strange_file_in_a_killed_run_is_refused_or_made_again(name, kind, tmp_path, whole):
    run = harmed(cut(whole, tmp_path / "run", 12), name, kind)
    before = sorted(run.iterdir())
    complaint = said(lambda: resume(run))
    if kind == "link" or name == "pushes.csv":
        assert name in complaint
        assert sorted(run.iterdir()) == before
    elif not complaint:
        same(run, whole)
    else:
        assert kind == "folder", "it is in the way"
    if kind == "link":
        assert (tmp_path / "elsewhere").read_text() == "mine"


@pytest.mark.parametrize("name", ["pushes.csv", "states.bin", ".lock", "figures", "recording-2.rrd"])
def test_a_resumed_run_writes_nothing_through_a_link(name, tmp_path, whole):
    run = cut(whole, tmp_path / "run", 12)
    elsewhere = tmp_path / "elsewhere"
    if (run / name).is_dir():
        shutil.rmtree(run / name)
        elsewhere.mkdir()
    elif (run / name).exists():
        (run / name).rename(elsewhere)
    (run / name).symlink_to(elsewhere)
    before = contents(tmp_path)
    with pytest.raises(UserError, match=f"{name}: a symbolic link") as caught:
        resume(run)
    assert (caught.value.exit_code, str(caught.value).count("\n")) == (2, 0)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("kind", STRANGE)
def test_a_strange_list_of_a_sweeps_runs_is_none(kind, tmp_path, whole, capsys):
    sweep = Path(shutil.copytree(whole, tmp_path / "sweep" / "run")).parent
    STRANGE[kind](sweep / "sweep.json")
    assert manifest.read(sweep) == []
    assert "1 runs" in said_by_status(sweep, capsys)


@pytest.mark.parametrize("name", ["../run", "a/../../run", "/etc", "", ".", 3, None, ["run"], "x" * 200_000])
def test_a_sweep_lists_no_run_outside_of_its_folder(name, tmp_path, whole, capsys):
    shutil.copytree(whole, tmp_path / "run")
    sweep = Path(shutil.copytree(whole, tmp_path / "sweep" / "run")).parent
    (sweep / "sweep.json").write_text(json.dumps({"jobs": [{"name": name, "overrides": []}]}))
    assert manifest.read(sweep) == []
    assert said_by_status(sweep, capsys).startswith(f"{sweep}: 1 runs\n")


def said_by_status(folder: Path, capsys) -> str:
    with contextlib.suppress(UserError):
        status.main([str(folder)])
    return capsys.readouterr().out


def test_a_page_holds_no_file_from_elsewhere(tmp_path, whole):
    """Neither as its figure nor as its settings."""
    run = Path(shutil.copytree(whole, tmp_path / "run"))
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "run.png").write_bytes(b"mine, not yours")
    shutil.rmtree(run / "figures", ignore_errors=True)
    (run / "figures").symlink_to(tmp_path / "elsewhere")
    assert said(lambda: report.main([str(run), "--out", str(tmp_path / "a.html")])) == ""
    assert base64.b64encode(b"mine, not yours").decode() not in (tmp_path / "a.html").read_text()
    (run / "figures").unlink()
    (run / "figures").mkdir()
    (run / "figures" / "run.png").symlink_to(tmp_path / "elsewhere" / "run.png")
    assert "run.png" in said(lambda: report.main([str(run), "--out", str(tmp_path / "b.html")]))


def contents(folder: Path) -> dict[Path, bytes | None]:
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def killed(whole: Path, folder: Path, pushes: int, tail: int) -> Path:
    """What a kill leaves while a run goes on: states that end at any byte, nothing that the end writes."""
    run = cut(whole, folder, pushes)
    (run / "contours.npz").unlink()
    (run / "views.npz").unlink()
    states = bytearray((whole.parent / "states.bin").read_bytes())
    (run / "states.bin").write_bytes(states[: len(states) - tail])
    return run


@pytest.fixture(scope="module")
def states(whole) -> Path:
    """The states of the run before it was closed: what `PosesWriter.close` reads."""
    from deformpush.record.poses import PosesWriter

    kept, close = whole.parent / "states.bin", PosesWriter.close

    def keep(self) -> None:
        shutil.copy(self._folder.states, kept)
        close(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PosesWriter, "close", keep)
        run = cut(whole, whole.parent / "again", 16)
        resume(run)
    return kept


@pytest.mark.parametrize("tail", [0, 1, 5_000, 40_000, 10**9])
def test_the_states_of_a_killed_run_are_read_as_far_as_they_are_whole(tail, tmp_path, whole, states, capsys):
    run = killed(whole, tmp_path / "run", 16, min(tail, states.stat().st_size))
    folder = RunFolder(run)
    if tail < 10**9:
        poses, all_of_them = read_poses(folder.contours), read_poses(whole / "contours.npz")
        count = len(poses.contours)
        assert count == 17 if tail == 0 else 1 < count < 17
        np.testing.assert_array_equal(poses.contours, all_of_them.contours[:count])
        run_figure.draw(folder)
        assert replay([str(run)]) == 0
        assert capsys.readouterr().out.startswith("identical: 16 pushes, errors and contours")
    assert len(table.read(folder.table)) == 17
    assert ended(resume(run))
    same(run, whole)
    assert not folder.states.exists()
