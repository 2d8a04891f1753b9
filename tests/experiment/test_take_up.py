"""A run whose world saves its states goes on from the last one, to the bit, and without it as before."""

import re
import shutil
import signal

import numpy as np
import pytest

from deformpush.experiment.run import resume
from deformpush.record import world_states
from deformpush.record.blocks import block
from deformpush.record.poses import read_poses
from deformpush.record.states import States, StatesWriter
from deformpush.record.world_states import BEFORE
from deformpush.worlds.mujoco.world import MujocoWorld
from deformpush.worlds.toy import ToyWorld
from tests.experiment.snapshots import alike, taken, with_snapshots
from tests.faults import ended_by, moments
from tests.setups import setup

KEEP = ["robot=tool", "record=off", "record.world_states=true", "stop=strict", "task.goal.offset=[0,0.3]"]
TOY = setup("world=toy", *KEEP, "max_pushes=14", "seed=3")
SOFT = setup("world=mujoco", *KEEP, "max_pushes=4", "optimizer.S0=2", "seed=3")


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    return with_snapshots(TOY, tmp_path_factory.mktemp("toy") / "run")


@pytest.fixture(scope="module")
def soft(tmp_path_factory):
    return with_snapshots(SOFT, tmp_path_factory.mktemp("soft") / "run")


@pytest.fixture
def made(monkeypatch):
    """Counts the pushes that are made."""
    pushes = []
    for world in (ToyWorld, MujocoWorld):
        whole = world.push
        monkeypatch.setattr(
            world, "push", lambda self, path, whole=whole: (pushes.append(path), whole(self, path))[1]
        )
    return pushes


@pytest.mark.parametrize("k", range(1, 15))
def test_a_run_goes_on_from_the_state_before_its_last_push(k, toy, tmp_path, made, capsys):
    folder = taken(toy, k, tmp_path / "run")
    assert resume(folder) is not None
    assert len(made) == 1 + 14 - k
    assert "again" not in capsys.readouterr().err
    alike(folder, toy)


@pytest.mark.parametrize("k", range(1, 5))
def test_so_does_that_of_a_soft_object(k, soft, tmp_path, made):
    folder = taken(soft, k, tmp_path / "run")
    assert resume(folder) is not None
    assert len(made) == 1 + 4 - k
    alike(folder, soft)


@pytest.mark.slow
@pytest.mark.parametrize("world", ["toy", "mujoco"])
@pytest.mark.parametrize(
    "method",
    [
        ["optimizer=abo_motion", "object=fish_fillet", "acquisition=safe_lcb", "acq.signal=contour"],
        ["optimizer=abo_motion", "robot=kuka_iiwa", "record=full"],
        ["optimizer=greedy"],
        ["optimizer=oracle", "optimizer.kappas=3", "optimizer.refined=1"],
    ],
    ids=["contour", "full", "greedy", "oracle"],
)
def test_so_does_every_method(method, world, tmp_path):
    if world == "toy":
        method = [text for text in method if not text.startswith("acq")]
    run = setup(f"world={world}", *KEEP, "max_pushes=6", *method, "record.world_states=true")
    whole = with_snapshots(run, tmp_path / "run")
    for k in range(1, 7):
        folder = taken(whole, k, tmp_path / f"again-{k}")
        assert resume(folder) is not None
        alike(folder, whole)


def test_an_object_that_turned_past_upright_keeps_its_angle(tmp_path, made):
    """A single look takes it for turned the other way; what was seen before tells."""
    upright = ("object.start_deg=88", "seed=0", "max_pushes=8", "optimizer=random")
    whole = with_snapshots(setup("world=toy", *KEEP, *upright), tmp_path / "run")
    thetas = read_poses(whole / "contours.npz").thetas
    (late, *_) = [k for k in range(2, 8) if abs(thetas[k - 1]) > np.pi / 2 + 0.1]
    folder = taken(whole, late, tmp_path / "again")
    made.clear()
    assert resume(folder) is not None
    assert len(made) == 1 + 8 - late
    alike(folder, whole)


def test_a_run_that_failed_goes_on_from_its_last_state(toy, tmp_path, made):
    """Its outlines and pictures are in contours.npz and views.npz by then."""
    folder = tmp_path / "run"
    shutil.copytree(toy, folder)
    (folder / "summary.json").unlink()
    assert resume(folder) is not None
    assert len(made) == 1
    alike(folder, toy)


def cut(data: bytes) -> bytes:
    return data[: len(data) // 2]


def flipped(data: bytes) -> bytes:
    at = len(data) - 20
    return data[:at] + bytes([data[at] ^ 8]) + data[at + 1 :]


def another(change):
    """The same states, each changed, with sums that are right."""

    def change_all(data: bytes) -> bytes:
        found = []
        while data:
            length = int.from_bytes(data[:4], "little")
            body, data = data[8 : 8 + length], data[8 + length :]
            found.append(block(body[: BEFORE.size] + change(body[BEFORE.size :])))
        return b"".join(found)

    return change_all


def moved(state: bytes) -> bytes:
    numbers = np.frombuffer(state[-24:], "<f8") + np.array([0.01, 0.0, 0.0])
    return state[:-24] + numbers.tobytes()


DAMAGE = {
    "empty": (lambda data: b"", 9),
    "zeros": (lambda data: bytes(5000), 9),
    "cut": (cut, 5),
    "a flipped bit": (flipped, 1),
    "of no world": (another(lambda state: b"nothing"), 9),
    "of another world": (another(lambda state: state[:25] + b"?" * 32 + state[57:]), 9),
    "not finite": (another(lambda state: state[:-8] + np.float64("nan").tobytes()), 9),
    "too long": (another(lambda state: state + bytes(8)), 9),
    "of another run": (another(moved), 9),
}
"""By name: what becomes of the file, and how many pushes are made again then."""


@pytest.mark.parametrize("name", DAMAGE)
def test_a_damaged_file_costs_time_and_nothing_else(name, toy, tmp_path, made, capsys):
    folder = taken(toy, 9, tmp_path / "run")
    harm, again = DAMAGE[name]
    file = folder / "world_states.bin"
    file.write_bytes(harm(file.read_bytes()))
    assert resume(folder) is not None
    told = capsys.readouterr().err
    assert (f"{folder}: makes all 9 pushes again: " in told) == (again == 9)
    assert told.count("\n") == (again == 9)
    assert len(made) == again + 5
    alike(folder, toy)


@pytest.mark.parametrize("name", ["world_states.bin", "states.bin", "checkpoint.npz"])
def test_a_file_that_is_missing_costs_time_and_nothing_else(name, toy, tmp_path, made, capsys):
    folder = taken(toy, 9, tmp_path / "run")
    (folder / name).unlink()
    assert resume(folder) is not None
    assert len(made) == 14
    assert f"{folder}: makes all 9 pushes again: " in capsys.readouterr().err
    alike(folder, toy)


def test_a_run_of_a_version_without_states_is_taken_up(toy, tmp_path, made, capsys):
    folder = taken(toy, 9, tmp_path / "run")
    (folder / "world_states.bin").unlink()
    text = (folder / "config.yaml").read_text()
    (folder / "config.yaml").write_text(re.sub(r"(?m)^ *world_states: .*\n", "", text))
    assert resume(folder) is not None
    assert "makes all 9 pushes again: there is no " in capsys.readouterr().err
    alike(folder, toy)


def test_an_outline_of_another_run_is_noticed(toy, tmp_path, made, capsys):
    """Of a push long before the one that is gone on from."""
    folder = taken(toy, 9, tmp_path / "run")
    file = folder / "states.bin"
    found = States(file)
    states = list(found)
    states[4] = states[4]._replace(numbers=states[4].numbers + 1e-3)
    StatesWriter(file, found.fixed, states).close()
    assert resume(folder) is not None
    assert "what is kept of push 4 is not what its row says" in capsys.readouterr().err
    assert len(made) == 14
    alike(folder, toy)


@pytest.mark.slow
@pytest.mark.parametrize(("row", "delay"), moments(6, 14, seed=4))
def test_a_killed_run_goes_on_to_the_bit(row, delay, toy, tmp_path):
    if ended_by(signal.SIGKILL, TOY, tmp_path / "run", row, delay):
        assert resume(tmp_path / "run") is not None
    alike(tmp_path / "run", toy)


@pytest.mark.slow
@pytest.mark.parametrize(("row", "delay"), moments(3, 4, seed=4))
def test_so_does_a_soft_object_that_was_killed_under(row, delay, soft, tmp_path):
    if ended_by(signal.SIGKILL, SOFT, tmp_path / "run", row, 10 * delay):
        assert resume(tmp_path / "run") is not None
    alike(tmp_path / "run", soft)


def test_a_state_that_leads_elsewhere_is_noticed(toy, tmp_path, made, monkeypatch, capsys):
    """It looks as recorded, but the push after it does not end as recorded."""
    folder, whole = taken(toy, 9, tmp_path / "run"), ToyWorld.restore
    pressures = []

    def restore(self, state):
        whole(self, state)
        pressures.append(self.pressure)
        self.pressure = 3 * self.pressure if len(pressures) == 1 else pressures[0]

    monkeypatch.setattr(ToyWorld, "restore", restore)
    assert resume(folder) is not None
    told = capsys.readouterr().err
    assert "makes all 9 pushes again: push 9 does not repeat itself: xi is" in told
    assert len(made) == 1 + 14
    alike(folder, toy)


def test_states_of_a_killed_run_are_read_to_the_last_whole_one(toy, tmp_path):
    data = (toy / "world_states.bin").read_bytes()
    size = len(data) // 15
    for end in range(0, len(data), 37):
        (tmp_path / "file").write_bytes(data[:end])
        assert [one.k for one in world_states.states(tmp_path / "file")] == list(range(end // size))


def test_without_the_setting_there_is_no_file(tmp_path):
    from deformpush.experiment.run import make_run

    make_run(setup("world=toy", "robot=tool", "record=off", "max_pushes=2", "optimizer=greedy"), tmp_path)
    assert not (tmp_path / "world_states.bin").exists()
