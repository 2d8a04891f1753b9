"""Viewers that watch a run live: one that is not there neither delays nor breaks the run."""

import shutil
import socket

import pytest

from deformpush.record.settings import SPAWNED
from deformpush.viewer import live
from tests.record.synthetic import SyntheticRun
from tests.viewer.recording import Contents, record

NOBODY = "rerun+http://127.0.0.1:9/proxy"


def test_a_viewer_that_is_not_there_does_not_hold_up_the_run(tmp_path, caplog):
    path = record(tmp_path / "run", SyntheticRun(2), connect=NOBODY)
    assert f"record.connect={NOBODY}: no viewer answers; the run goes on without one" in caplog.text
    assert Contents(path).times("/camera/image", "push") == [0, 1, 2]


def test_a_window_that_cannot_open_does_not_hold_up_the_run(tmp_path, caplog, monkeypatch):
    """The program ends at once where there is no display."""
    monkeypatch.setattr(live, "WINDOWS", [])
    monkeypatch.setattr(live, "program", lambda: shutil.which("false"))
    monkeypatch.setattr(live, "SPAWNED", NOBODY)
    path = record(tmp_path / "run", SyntheticRun(2), spawn=True)
    assert "record.spawn=true: no viewer answers; the run goes on without one" in caplog.text
    assert Contents(path).times("/camera/image", "push") == [0, 1, 2]


def test_a_viewer_that_listens_is_streamed_to():
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        address = f"rerun+http://127.0.0.1:{listening.getsockname()[1]}/proxy"
        assert live.viewers(False, address) == [address]


def test_nobody_is_asked_where_nobody_shall_watch():
    assert live.viewers(False, None) == []


def test_a_window_that_is_open_already_is_used_again(monkeypatch):
    monkeypatch.setattr(live, "_answers", lambda address: address == SPAWNED)
    monkeypatch.setattr(live, "_window", lambda: pytest.fail("a second window"))
    assert live.viewers(True, None) == [SPAWNED]


def test_the_program_comes_with_the_library():
    assert live.program().is_file()
