"""State files hold plain arrays and JSON, and damaged ones are refused."""

import json

import numpy as np
import pytest

from deformpush.optimizer import ABO, Adaptive, Components
from deformpush.record.checkpoint import Checkpoint, load, read, save, write


def abo(seed):
    return ABO(parts=Components(bounds=Adaptive(d=(0.01, 0.03)), rng=np.random.default_rng(seed)), S0=4)


def test_a_saved_optimizer_asks_for_the_same_push(tmp_path):
    opt, twin = abo(0), abo(1)
    for t in range(9):
        u = opt.ask().u
        opt.tell(u, -u[0] * np.cos(t / 5))
    with pytest.raises(ValueError, match="finite"):
        opt.tell(u, np.nan)
    asked = opt.ask()
    save(tmp_path / "state.npz", opt.state())
    twin.restore(load(tmp_path / "state.npz"))
    again = twin.ask()
    np.testing.assert_array_equal(again.u, asked.u)
    assert (again.acq, again.mean, again.std) == (asked.acq, asked.mean, asked.std)
    assert twin.rejected == 1
    assert [p.name for p in tmp_path.iterdir()] == ["state.npz"]


def test_the_file_is_arrays_and_json(tmp_path):
    opt = abo(0)
    save(tmp_path / "state.npz", opt.state())
    with np.load(tmp_path / "state.npz", allow_pickle=False) as file:
        assert json.loads(str(file["json"]))["fitted"] == -1
        assert {file[name].dtype.kind for name in file.files} <= {"f", "i", "U"}


def test_damage_is_named(tmp_path):
    path = tmp_path / "state.npz"
    save(path, abo(0).state())
    whole = path.read_bytes()
    for broken in (whole[: len(whole) // 2], b"", b"hello"):
        path.write_bytes(broken)
        with pytest.raises(ValueError, match="not a whole optimizer state"):
            load(path)
    np.savez(path, a=np.zeros(3))
    with pytest.raises(ValueError, match="not a whole optimizer state"):
        load(path)
    np.savez(path, json=np.array("[1]"))
    with pytest.raises(ValueError, match="not a whole optimizer state"):
        load(path)
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "none.npz")


def test_a_checkpoint_knows_the_push_it_follows(tmp_path):
    path = tmp_path / "checkpoint.npz"
    write(path, 7, {"k": 3, "U": np.ones((2, 2)), "names": ["a", None]})
    found = read(path)
    assert found is not None
    assert (found.k, found.state["k"], found.state["names"]) == (7, 3, ["a", None])
    np.testing.assert_array_equal(found.state["U"], np.ones((2, 2)))
    assert isinstance(found, Checkpoint)


def test_a_checkpoint_that_is_not_whole_is_none(tmp_path):
    path = tmp_path / "checkpoint.npz"
    assert read(path) is None
    write(path, 7, {"a": np.zeros(9)})
    path.write_bytes(path.read_bytes()[:-20])
    assert read(path) is None
    save(path, {"state.a": 1})
    assert read(path) is None, "it names no push"
