"""A finished recording is one small file with the contents, the identity and the layout of its parts."""

import errno
import shutil
import threading
from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb

from deformpush.viewer import compact as module
from deformpush.viewer.compact import check_room, compact, identity_of, let_go
from deformpush.viewer.panel import set_time
from tests.viewer.recording import Contents

LAYOUT = rrb.Blueprint(rrb.Vertical(rrb.TimeSeriesView(origin="a", name="All of it")))
PUSHES = 40


@pytest.fixture
def parts(tmp_path):
    """A recording in two files, flushed at every push."""
    made = [tmp_path / "recording.rrd", tmp_path / "recording-2.rrd"]
    for path, pushes in zip(made, np.split(np.arange(PUSHES), 2), strict=True):
        rec = rr.RecordingStream("test", recording_id="the-one")
        rec.set_sinks(rr.FileSink(path), default_blueprint=rrb.Blueprint(rrb.TextDocumentView(name="old")))
        for k in pushes.tolist():
            set_time(rec, k, float(k))
            rec.log("a", rr.Scalars(k**2))
            rec.flush(timeout_sec=10)
        rec.disconnect()
    return made


def test_the_parts_become_one(parts):
    sizes = sum(path.stat().st_size for path in parts)
    compact(parts, parts[0], LAYOUT)
    contents = Contents(parts[0])
    values = {k: [k**2] for k in range(PUSHES)}
    assert contents.at("/a", "Scalars:scalars") == values
    assert len(contents.at("/a", "Scalars:scalars", "sim_time")) == PUSHES
    assert (contents.entry.application_id, contents.entry.recording_id) == ("test", "the-one")
    assert [view.name for view in contents.views] == ["All of it"]
    assert list(parts[0].parent.iterdir()) == [parts[0]]
    assert parts[0].stat().st_size < sizes / 2


def test_parts_that_cannot_be_joined_stay(parts):
    parts[1].write_bytes(b"hello")
    before = parts[0].read_bytes()
    with pytest.raises((OSError, RuntimeError, ValueError)):
        compact(parts, parts[0], LAYOUT)
    assert parts[0].read_bytes() == before
    assert sorted(parts[0].parent.iterdir()) == sorted(parts)


def test_without_room_nothing_is_begun(parts, monkeypatch):
    usage = namedtuple("usage", "total used free")(1, 1, module.ROOM_BYTES + 100)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage)
    check_room(parts[0].parent, 100)
    with pytest.raises(OSError, match="No space left") as caught:
        check_room(parts[0].parent, 101)
    assert caught.value.errno == errno.ENOSPC
    with pytest.raises(OSError, match="No space left"):
        compact(parts, parts[0], LAYOUT)
    assert len(list(parts[0].parent.iterdir())) == 2


def test_a_recording_has_an_identity_and_a_damaged_one_has_none(parts):
    assert identity_of(parts[0]) == "the-one"
    parts[0].write_bytes(b"hello")
    assert identity_of(parts[0]) is None
    assert identity_of(parts[0].with_name("none.rrd")) is None


def test_a_stream_that_does_not_end_is_left_behind(monkeypatch):
    answered, left = threading.Event(), []
    monkeypatch.setattr(module, "CLOSE_S", 0.05)
    monkeypatch.setattr(module.atexit, "unregister", left.append)
    let_go(SimpleNamespace(disconnect=answered.wait))
    assert left == [rr.rerun_shutdown], "the end of the process does not wait for it either"
    answered.set()
    let_go(SimpleNamespace(disconnect=answered.wait))
    assert len(left) == 1
