"""A folder is locked by one at a time, and free again when its holder ends, however it ends."""

import os
import signal

import pytest

from deformpush.record.lock import Lock, held


def test_one_holds_a_folder_at_a_time(tmp_path):
    assert not held(tmp_path)
    lock = Lock.take(tmp_path)
    assert held(tmp_path)
    assert Lock.take(tmp_path) is None
    lock.release()
    lock.release()
    assert not held(tmp_path)
    Lock.take(tmp_path).release()


def test_the_lock_of_a_killed_process_is_gone(tmp_path):
    ready, writing = os.pipe()
    child = os.fork()
    if child == 0:
        Lock.take(tmp_path)
        os.write(writing, b".")
        signal.pause()
    os.read(ready, 1)
    assert held(tmp_path)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    assert not held(tmp_path)


def test_a_folder_that_is_not_there_is_held_by_nobody(tmp_path):
    assert not held(tmp_path / "none")
    with pytest.raises(OSError, match="No such file"):
        Lock.take(tmp_path / "none")
