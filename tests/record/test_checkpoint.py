"""State files hold plain arrays and JSON, and damaged ones are refused."""

import json

import numpy as np
import pytest

from deformpush.optimizer import ABO, Adaptive, Components
from deformpush.optimizer.storage import load, save


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
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "none.npz")
