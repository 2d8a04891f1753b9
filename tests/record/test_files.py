"""Files appear whole or not at all, and damaged ones are refused."""

import os

import numpy as np
import pytest

from deformpush.record.files import read_npz, replacing, write_npz, write_whole


def test_a_write_that_fails_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "file"
    write_whole(path, b"old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_without_sync_the_disk_is_not_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: pytest.fail("waited"))
    write_whole(tmp_path / "file", b"all", sync=False)
    assert (tmp_path / "file").read_bytes() == b"all"


def test_a_file_takes_its_place_when_its_maker_is_done(tmp_path):
    path = tmp_path / "film.mp4"
    with replacing(path) as temporary:
        temporary.write_text("new")
        assert (temporary.parent, temporary.suffix) == (tmp_path, ".mp4"), "makers go by the suffix"
        assert not path.exists()
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_maker_that_fails_leaves_the_old_file(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_text("old")

    def half() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_arrays_come_back_by_name(tmp_path):
    path = tmp_path / "a.npz"
    write_npz(path, {"a": [[1.0, np.nan]], "b": np.arange(3), "c": 0.5})
    found = read_npz(path)
    assert set(found) == {"a", "b", "c"}
    np.testing.assert_array_equal(found["a"], [[1.0, np.nan]])
    assert set(read_npz(path, ["b"])) == {"b"}
    with pytest.raises(ValueError, match="damaged, or not written by a run"):
        read_npz(path, ["d"])
    with pytest.raises(ValueError, match="allow_pickle"):
        write_npz(path, {"a": np.array([object()])})


@pytest.mark.parametrize("damage", [b"", b"hello", "cut"])
def test_a_damaged_file_is_refused_in_one_line(tmp_path, damage):
    path = tmp_path / "a.npz"
    write_npz(path, {"a": np.arange(100)})
    path.write_bytes(path.read_bytes()[:-50] if damage == "cut" else damage)
    with pytest.raises(ValueError, match="damaged, or not written by a run") as caught:
        read_npz(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(FileNotFoundError):
        read_npz(tmp_path / "none.npz")
