"""No room while a verb writes what it made of runs: one line, exit code 1, and nothing half-written."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from deformpush.cli import compare, report, status, video
from deformpush.errors import TroubleError
from deformpush.experiment.run import make_run, resume
from deformpush.record.finished import read
from deformpush.record.folder import RunFolder
from deformpush.study import run_figure
from deformpush.study.run_data import read as read_data
from tests.experiment.test_faults import disk, made_so_far, mount
from tests.experiment.test_resume import TOY, cut, same
from tests.experiment.test_resume import whole as whole_run
from tests.pages import ROOT
from tests.setups import setup

whole = whole_run
VERBS = {
    "compare.csv": (compare.main, "--out", 4),
    "compare.png": (compare.main, "--out", 24),
    "compare.rrd": (compare.main, "--out", 400),
    "report.html": (report.main, "--out", 60),
    "video.mp4": (video.main, "--out", 8),
}
"""By file: who writes it, and a disk (kB) on which it finds no room."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "video.mp4")) for name in VERBS]
)
def test_a_verb_that_finds_no_room_says_so_and_leaves_no_part(name, tmp_path, whole, capsys):
    main, flag, size_kB = VERBS[name]
    with disk(tmp_path / "small", size_kB) as small:
        out = small if main is compare.main else small / name
        (small / "other").write_bytes(bytes(4000))
        with pytest.raises(
            TroubleError, match=rf"{name}: cannot be written \(No space left on device\)"
        ) as caught:
            main([str(whole), flag, str(out)])
        assert (caught.value.exit_code, caught.value.line.count("\n")) == (1, 0)
        left = {file.name for file in small.iterdir()} - {"other"}
        assert name not in left
        assert left <= {"compare.csv", "compare.png"}, "whole ones, written before"
        mount("-o", "remount,size=64m", str(small))
        again = ["--overwrite"] if left else []
        assert main([str(whole), flag, str(out), *again]) == 0
        assert (small / name).stat().st_size > 0
    assert ended_still(whole)


def ended_still(run: Path) -> bool:
    """Whether a finished run can be read as before."""
    read_data(RunFolder(run))
    return read(RunFolder(run), "run").summary.pushes == 16


def test_a_run_without_room_for_its_figure_is_whole(tmp_path, monkeypatch, whole, capsys):
    def full(folder: RunFolder) -> None:
        raise OSError(28, "No space left on device")

    made = setup(*TOY[:3], *TOY[3:], "record.figures=true", "max_pushes=16", "seed=3")
    monkeypatch.setattr(run_figure, "draw", full)
    with pytest.raises(
        TroubleError, match=r"the run is whole, but its figure lacks \(No space left"
    ) as caught:
        make_run(made, tmp_path / "run")
    assert caught.value.exit_code == 1
    assert capsys.readouterr().out.startswith("budget: ")
    same(tmp_path / "run", whole)
    assert resume(tmp_path / "run") is None


def carry_out(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """Carry out a command of the shell in which `deformpush` stands for the package."""
    command = line.replace("deformpush", f"{sys.executable} -m deformpush", 1)
    settings = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    return subprocess.run(["bash", "-c", command], cwd=folder, env=settings, capture_output=True, check=False)


RUN_LINE = f"deformpush {' '.join(TOY)} max_pushes=16 seed=3 hydra.run.dir=run"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("output", "code", "said"),
    [
        ("> /dev/full", 1, b"standard output: cannot be written (No space left on device)\n"),
        (">&-", 0, b""),
        ("| true; exit ${PIPESTATUS[0]}", 0, b""),
        ("2>&-", 0, b""),
        ("2> /dev/full", 0, b""),
    ],
)
def test_a_run_does_not_end_because_nobody_can_read_what_it_says(output, code, said, tmp_path, whole):
    done = carry_out(f"{RUN_LINE} {output}", tmp_path)
    assert (done.returncode, done.stderr) == (code, said)
    same(tmp_path / "run", whole)


@pytest.mark.slow
def test_a_run_on_a_terminal_that_knows_ascii_alone(tmp_path, whole):
    folder = tmp_path / "r\u00fcn"
    folder.mkdir()
    done = carry_out(RUN_LINE, folder, PYTHONIOENCODING="ascii", LC_ALL="C")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"r\\xfcn" in done.stdout
    same(folder / "run", whole)


@pytest.mark.slow
def test_status_for_a_reader_that_takes_one_line(tmp_path, whole):
    shutil.copytree(whole, tmp_path / "many" / "one")
    for n in range(30):  # more than a pipe's reader takes
        cut(whole, tmp_path / "many" / f"other-{n}", 3)
    done = carry_out("deformpush status many | head -1; exit ${PIPESTATUS[0]}", tmp_path)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout == b"many: 31 runs\n"


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize("size_kB", [84, 2400])
def test_a_full_disk_in_a_run_of_a_soft_object(size_kB, tmp_path):
    """In Bullet; the larger disk fills while the recording grows."""
    record = "record=off" if size_kB < 1000 else "record=light"
    made = setup("robot=tool", record, "record.figures=false", "max_pushes=8", "optimizer.S0=4", "seed=3")
    make_run(made, tmp_path / "whole")
    with disk(tmp_path / "small", size_kB) as small:
        with pytest.raises(TroubleError, match=r"cannot be written any more \(No space left on") as caught:
            make_run(made, small / "run")
        assert caught.value.exit_code == 1
        assert 0 < made_so_far(small / "run", tmp_path / "whole") < 8
        assert status.main([str(small)]) == 0
        mount("-o", "remount,size=64m", str(small))
        summary = resume(small / "run")
        assert summary is not None
        assert summary.pushes == 8
        same(small / "run", tmp_path / "whole")
        assert compare.main([str(small / "run"), "--out", str(tmp_path / "out")]) == 0
    assert json.loads((tmp_path / "whole" / "summary.json").read_text())["pushes"] == 8
