"""What another push would have done: the same as if it had been made then, to the bit."""

import shutil

import numpy as np
import pytest

import deformpush
from deformpush.cli import replay, whatif
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.run import make_run
from deformpush.experiment.take_up import KEPT
from deformpush.record.blocks import block
from deformpush.record.poses import read_pictures, read_poses
from deformpush.record.table import TIMES, read, read_rows
from deformpush.worlds.bullet.world import BulletWorld
from deformpush.worlds.mujoco.world import MujocoWorld
from deformpush.worlds.toy import ToyWorld
from tests.setups import begun, setup
from tests.viewer.recording import Contents

KEEP = ["robot=tool", "record=off", "record.world_states=true", "task.goal.offset=[0,0.3]", "seed=2"]
RUNS = {
    "toy": setup("world=toy", *KEEP, "max_pushes=8", "optimizer.S0=3", "stop=strict"),
    "mujoco": setup("world=mujoco", *KEEP, "max_pushes=3", "optimizer=random"),
}


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("toy") / "run"
    make_run(RUNS["toy"], folder)
    return folder


@pytest.fixture(scope="module")
def mujoco(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mujoco") / "run"
    make_run(RUNS["mujoco"], folder)
    return folder


@pytest.fixture(params=["toy", "mujoco"])
def world(request):
    return request.param


def straight(made, folder, push: int, u: tuple[float, float]):
    """The other push, made without any state: all pushes before it are made."""
    episode, rows = begun(made), read_rows(folder / "pushes.csv")
    for row in rows[1:push]:
        episode.push(u=np.array([row["kappa"], row["d"]]))
    return episode.push(u=np.array(u))


def test_a_branch_is_the_run_with_another_push(world, request):
    folder, push, u = request.getfixturevalue(world), 3, (0.6, 0.02)
    before = {file.name: file.stat().st_mtime_ns for file in folder.iterdir()}
    expected = straight(RUNS[world], folder, push, u)
    with deformpush.load(folder).branch(push) as branch:
        first = branch.push(*u)
        branch.push(0.2, 0.03)
        for record in (first, branch.push(*u)):
            assert record.k == push
            assert record.errors == expected.errors
            np.testing.assert_array_equal(record.view.picture, expected.view.picture)
            np.testing.assert_array_equal(record.view.nodes, expected.view.nodes)
            assert record.view.seen.theta == expected.view.seen.theta
            assert record.action.outcome.strain == expected.action.outcome.strain
            assert record.timing.sim_time_s == expected.timing.sim_time_s
        assert branch.made.errors.e_T == read_rows(folder / "pushes.csv")[push]["e_T"] != first.errors.e_T
        assert branch.e_T_after(np.array([u, (0.1, 0.02)]))[0] == first.errors.e_T
    assert {file.name: file.stat().st_mtime_ns for file in folder.iterdir()} == before


def test_the_first_and_the_last_push_can_be_others(toy):
    for push in (1, 8):
        with deformpush.load(toy).branch(push) as branch:
            expected = straight(RUNS["toy"], toy, push, (0.3, 0.02))
            assert branch.push(0.3, 0.02).errors == expected.errors


@pytest.mark.parametrize(
    ("push", "u", "message"),
    [
        (0, (0.5, 0.02), "push = 0: must be 1 to 8, the pushes of "),
        (9, (0.5, 0.02), "push = 9: must be 1 to 8, the pushes of "),
        (3, (1.5, 0.02), r"kappa = 1.5: must be 0 to 1, as bounds.kappa says"),
        (3, (0.5, 0.2), r"d = 0.2: must be 0.01 to 0.03, as bounds.d says"),
        (3, (float("nan"), 0.02), r"kappa = nan: must be 0 to 1"),
        (3, (0.5, 0.02, 0.0), "speed = 0: must be more than 0"),
    ],
)
def test_what_is_no_push_is_refused(push, u, message, toy):
    with pytest.raises(UserError, match=message), deformpush.load(toy).branch(push) as branch:
        branch.push(*u)


def test_it_says_what_both_pushes_did(mujoco, capsys):
    assert whatif.main([str(mujoco), "--push", "2", "kappa=0.6", "d=0.02"]) == 0
    head, _, *table, last = capsys.readouterr().out.splitlines()
    assert head == f"push 2 of {mujoco}, from the state after push 1"
    rows = read_rows(mujoco / "pushes.csv")
    other = straight(RUNS["mujoco"], mujoco, 2, (0.6, 0.02))
    told = {line[:20].strip(): line[20:].split() for line in table}
    assert told["kappa"] == [f"{rows[2]['kappa']:.4f}", "0.6000"]
    assert told["position error (mm)"] == [
        f"{x * 1e3:.2f}" for x in (rows[2]["position_error_m"], other.errors["position_error_m"])
    ]
    assert told["peak strain (%)"] == [
        f"{100 * x:.2f}" for x in (rows[2]["strain_p99_peak"], other.action.outcome.strain.p99_peak)
    ]
    assert told["tool force, peak (N)"][1] == f"{other.action.outcome.tool_force_peak:.3f}"
    by = other.errors.e_T - rows[2]["e_T"]
    assert last == f"e_T would have been {abs(by):.4f} {'larger' if by > 0 else 'smaller'}"


def test_what_is_not_told_stays_as_it_was(toy, capsys):
    assert whatif.main([str(toy), "--push", "4", "d=0.02"]) == 0
    assert [
        line.split()[1:] for line in capsys.readouterr().out.splitlines() if line.startswith("kappa")
    ] == [[f"{read_rows(toy / 'pushes.csv')[4]['kappa']:.4f}"] * 2]


def test_it_is_recorded_beside_the_original(toy, tmp_path, capsys):
    into = tmp_path / "other"
    assert whatif.main([str(toy), "--push", "5", "kappa=0.6", "d=0.02", "--into", str(into)]) == 0
    assert f"written: {into}, with the pushes up to 5" in capsys.readouterr().out
    assert (into / "compare.rrd").stat().st_size > 10_000
    run = deformpush.load(into)
    assert run.summary.reason == f"what if push 5 of {toy} had been another"
    a, b = (read(path / "pushes.csv").drop(columns=list(TIMES)) for path in (toy, into))
    assert a[:5].equals(b[:5])
    assert (b["kappa"][5], b["d"][5], b["phase"][5]) == (0.6, 0.02, "what if")
    np.testing.assert_array_equal(run.contours[:5], read_poses(toy / "contours.npz").contours[:5])
    assert read_pictures(into / "views.npz")[:5] == read_pictures(toy / "views.npz")[:5]
    assert not (into / "checkpoint.npz").exists()
    expected = straight(RUNS["toy"], toy, 5, (0.6, 0.02))
    np.testing.assert_array_equal(run.contours[5], expected.view.seen.contour)
    assert replay.main([str(into)]) == 1  # the optimizer wanted another
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "identical: 5 pushes, errors and contours to the last bit"
    assert lines[1].startswith("decides otherwise: really, first at push 5: ")
    with run.branch(5) as again:
        assert again.made.errors == expected.errors


def test_it_is_recorded_with_all_there_is(toy, tmp_path):
    """A run that was killed and is recorded in full."""
    made = setup("world=toy", "robot=tool", "max_pushes=4", "optimizer=greedy", "record.figures=false")
    make_run(made, tmp_path / "run")
    (tmp_path / "run" / "summary.json").unlink()
    line = [str(tmp_path / "run"), "--push", "3", "kappa=0.6", "d=0.02", "--into", str(tmp_path / "other")]
    assert whatif.main(line) == 0
    views = Contents(tmp_path / "other" / "recording.rrd").times("/camera/image", "push")
    assert views == [0, 1, 2, 3]
    with pytest.raises(UserError, match="already holds results"):
        whatif.main(line)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("--push 3", "kappa=, d= or speed= must say what the other push is"),
        ("--push 3 seed=4", "seed=4: a push has kappa=, d= .m. and speed= .m/s."),
        ("--push 3 kappa=left", "kappa = left: must be a number"),
        ("--push 3 kappa=0.5 --into {run}", "already holds results"),
        ("--push 99 kappa=0.5", "push = 99: must be 1 to 8"),
    ],
)
def test_mistakes_are_one_line(line, message, toy):
    with pytest.raises(UserError, match=message) as caught:
        whatif.main([str(toy), *line.format(run=toy).split()])
    assert "\n" not in caught.value.line
    assert caught.value.exit_code == 2


def test_a_push_that_cannot_be_made_is_one_line(toy, monkeypatch):
    def push(self, path):
        if abs(path.d - 0.0123) < 1e-9:
            raise deformpush.WorldError("it sticks")
        return whole(self, path)

    whole = ToyWorld.push
    monkeypatch.setattr(ToyWorld, "push", push)
    with pytest.raises(TroubleError, match="the other push cannot be made: it sticks"):
        whatif.main([str(toy), "--push", "3", "d=0.0123"])


@pytest.fixture
def stateless(toy, tmp_path):
    """A run that kept no states."""
    shutil.copytree(toy, tmp_path / "run")
    (tmp_path / "run" / "world_states.bin").unlink()
    return tmp_path / "run"


@pytest.mark.parametrize("verb", ["whatif", "replay"])
def test_a_run_without_states_is_refused_in_a_line_that_says_which_worlds_have_them(verb, stateless):
    line = {"whatif": (whatif, "--push 3 kappa=0.5"), "replay": (replay, "--from 3")}
    module, flags = line[verb]
    with pytest.raises(UserError) as caught:
        module.main([str(stateless), *flags.split()])
    told = caught.value.line
    file = stateless / "world_states.bin"
    assert told == f"{stateless}: cannot begin with push 3: there is no {file}; {KEPT}"


def test_a_world_without_states_is_refused(toy, monkeypatch):
    monkeypatch.setattr(ToyWorld, "offers", ToyWorld.offers - {"states"})
    with pytest.raises(UserError, match="cannot begin with push 3: its world saves no states; record"):
        whatif.main([str(toy), "--push", "3", "kappa=0.5"])


def test_the_worlds_that_are_named_are_those_that_save_states():
    named = {world for world in (BulletWorld, MujocoWorld, ToyWorld) if "states" in world.offers}
    assert {world.__name__.removesuffix("World").lower() for world in named} == {
        name for name in ("bullet", "mujoco", "toy") if f"world={name}" in KEPT
    }


def test_a_state_of_another_place_is_noticed(toy, tmp_path):
    shutil.copytree(toy, tmp_path / "run")
    file, blocks = tmp_path / "run" / "world_states.bin", []
    data = file.read_bytes()
    while data:
        length = int.from_bytes(data[:4], "little")
        blocks.append(data[8 : 8 + length])
        data = data[8 + length :]
    blocks[2] = blocks[2][:16] + blocks[1][16:]
    file.write_bytes(b"".join(map(block, blocks)))
    with pytest.raises(UserError, match="what is kept of push 2 is not what its row says"):
        whatif.main([str(tmp_path / "run"), "--push", "3", "kappa=0.5"])


@pytest.mark.parametrize("k", [1, 2, 5, 8])
def test_a_replay_begins_anywhere(k, toy, capsys, monkeypatch):
    made, whole = [], ToyWorld.push
    monkeypatch.setattr(ToyWorld, "push", lambda self, path: (made.append(path), whole(self, path))[1])
    assert replay.main([str(toy), "--from", str(k)]) == 0
    count = 9 - k
    assert len(made) == count
    told = f"identical: {count} push{'es' * (count > 1)}, errors and contours to the last bit\n"
    assert capsys.readouterr().out == told


def test_a_replay_from_the_middle_notices_what_differs(toy, capsys, monkeypatch):
    whole = ToyWorld.push

    def push(self, path):
        outcome = whole(self, path)
        self.c = np.add(self.c, (0.002, 0.0))
        return outcome

    monkeypatch.setattr(ToyWorld, "push", push)
    assert replay.main([str(toy), "--from", "6"]) == 1
    assert capsys.readouterr().out.startswith("differs really, first at push 6: ")


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ("--from 9", "--from 9: must be 1 to 8, the pushes of "),
        ("--from 0", "--from 0: must be 1 to 8, the pushes of "),
        ("--from 3 --into {new}", "--from 3: not with --into"),
    ],
)
def test_a_replay_that_cannot_begin_there_is_refused(flags, message, toy, tmp_path):
    with pytest.raises(UserError, match=message):
        replay.main([str(toy), *flags.format(new=tmp_path / "new").split()])
