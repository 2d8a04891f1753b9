"""Others at work in a run's folder: a second command, somebody who moves it, a user who may only read."""

import json
import os
import shutil
import signal
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from deformpush.cli import compare, status
from deformpush.cli.replay import main as replay
from deformpush.errors import Stopped, TroubleError, UserError
from deformpush.experiment.recorder import Recorder
from deformpush.experiment.run import make_run, resume
from tests.experiment.test_faults import at_once
from tests.experiment.test_resume import RUN, cut, ended, same
from tests.experiment.test_resume import whole as whole_run
from tests.faults import ended_by, in_child

whole = whole_run


def test_of_a_run_and_a_resumption_begun_at_once_one_works_in_the_folder(tmp_path, whole):
    folder = cut(whole, tmp_path / "run", 8)
    assert at_once([lambda: make_run(RUN, folder), lambda: resume(folder)]) == [2, 0]
    same(folder, whole)


def test_the_folder_of_a_run_that_goes_on_cannot_be_resumed_by_another(tmp_path, whole, monkeypatch):
    codes, record = [], Recorder.__call__

    def meanwhile(self, one):
        seconds = record(self, one)
        if one.k == 7:
            codes.extend(at_once([lambda: resume(self.folder.path)]))
        return seconds

    monkeypatch.setattr(Recorder, "__call__", meanwhile)
    make_run(RUN, tmp_path / "run")
    assert codes == [2]
    same(tmp_path / "run", whole)


@pytest.mark.parametrize("push", [3, 15])
def test_a_folder_that_is_moved_away_during_a_run_is_whole_there(push, tmp_path, whole, monkeypatch):
    record = Recorder.__call__

    def moved(self, one):
        if one.k == push:
            (tmp_path / "run").rename(tmp_path / "elsewhere")
        return record(self, one)

    with monkeypatch.context() as patch:
        patch.setattr(Recorder, "__call__", moved)
        with pytest.raises(TroubleError, match=r"cannot be written any more \(No such file or dir") as caught:
            make_run(RUN, tmp_path / "run")
    assert (caught.value.exit_code, caught.value.line.count("\n")) == (1, 0)
    assert not (tmp_path / "run").exists()
    assert status.main([str(tmp_path)]) == 0
    assert ended(resume(tmp_path / "elsewhere"))
    same(tmp_path / "elsewhere", whole)


@pytest.fixture
def public(whole) -> Iterator[Path]:
    """A folder where everybody can read two runs, one of them unfinished, and only this user can write."""
    if os.geteuid():
        pytest.skip("needs the right to become another user")
    folder = Path(tempfile.mkdtemp())
    folder.chmod(0o755)
    try:
        shutil.copytree(whole, folder / "done")
        cut(whole, folder / "cut", 8)
        yield folder
    finally:
        shutil.rmtree(folder)


def said_by_another_user(folder: Path, work: Callable[[], object]) -> tuple[int, str]:
    """Exit code and complaint of a command that somebody else gives, who may write nowhere here."""
    told, writing = os.pipe()

    def as_nobody() -> None:
        os.setgroups([])
        os.setgid(65534)
        os.setuid(65534)
        os.chdir(folder)
        code, line = 0, ""
        try:
            work()
        except UserError as error:
            code, line = error.exit_code, error.line
        os.write(writing, line.encode())
        os._exit(code)

    child = in_child(as_nobody)
    os.close(writing)
    with os.fdopen(told) as reader:
        line = reader.read()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), line


def test_a_user_who_may_only_read_changes_nothing_and_is_told_in_one_line(public, whole):
    with suppress(UserError):
        replay([str(public / "done")])  # all that a child needs is imported
    before = {file: file.stat().st_mtime_ns for file in public.rglob("*")}
    refused = {
        "resume": lambda: resume(public / "cut"),
        "run": lambda: make_run(RUN, public / "new"),
        "again": lambda: make_run(RUN, public / "done"),
        "compare": lambda: compare.main([str(public)]),
    }
    for name, work in refused.items():
        code, line = said_by_another_user(public, work)
        assert code == 2, (name, line)
        assert "\n" not in line
        assert str(public) in line
        if name != "again":
            assert "cannot write there" in line, name
    for work in (lambda: status.main([str(public)]), lambda: replay([str(public / "cut")])):
        assert said_by_another_user(public, work) == (0, "")
    assert {file: file.stat().st_mtime_ns for file in public.rglob("*")} == before
    assert ended(resume(public / "cut"))
    same(public / "cut", whole)


def test_a_run_that_a_closed_terminal_ended_says_so(tmp_path, whole):
    ended_by(signal.SIGHUP, RUN, tmp_path / "run", 5, 0.0)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert (summary["status"], summary["reason"]) == ("interrupted", "stopped from outside (SIGHUP)")


def test_a_stop_in_a_line_whose_clean_up_complains_is_a_stop_all_the_same(tmp_path, whole, monkeypatch):
    pushes = 0
    save = np.savez

    def interrupted(*args, **arrays):
        nonlocal pushes
        pushes += 1
        if pushes < 4:
            return save(*args, **arrays)
        try:
            raise Stopped("stopped from outside (SIGTERM)")
        finally:
            raise ValueError("Can't close the ZIP file while there is an open writing handle on it.")

    with monkeypatch.context() as patch:
        patch.setattr(np, "savez", interrupted)
        with pytest.raises(Stopped):
            make_run(RUN, tmp_path / "run")
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert (summary["status"], summary["reason"]) == ("interrupted", "stopped from outside (SIGTERM)")
    assert ended(resume(tmp_path / "run"))
    same(tmp_path / "run", whole)
