"""Regret: what the best push would have gained in every state, beside what was foreseen."""

import re
import shutil

import numpy as np
import pytest

import deformpush
from deformpush.cli import regret
from deformpush.errors import TroubleError, UserError
from deformpush.experiment import true_regret
from deformpush.experiment.run import make_run
from deformpush.experiment.true_regret import candidates
from deformpush.optimizer.rivals.oracle import Oracle
from deformpush.record.folder import RunFolder
from deformpush.record.regret_table import COLUMNS, read, read_trials
from deformpush.record.table import read_rows
from deformpush.state import Proposal
from deformpush.study import regret_figure
from deformpush.worlds.toy import ToyWorld
from tests.setups import begun, setup

TOY = ["world=toy", "robot=tool", "record=off", "task.goal.offset=[0,0.3]", "seed=2", "stop=strict"]
N = 8
FILES = ("regret.csv", "regret_trials.csv")


def make(folder, *settings):
    """A run of a few pushes."""
    made = setup(*TOY, *settings)
    make_run(made, folder)
    return folder


@pytest.fixture(autouse=True)
def no_figure(request, monkeypatch):
    """Drawing takes longer than all else here; one test does."""
    if getattr(request.node, "callspec", None) is None or request.node.callspec.params.get("rank") != 1:
        monkeypatch.setattr(regret_figure, "draw", lambda *columns: b"a figure")


@pytest.fixture(autouse=True)
def no_forks(monkeypatch):
    """Returning to a saved state is quicker than a copy of the process; test_fork.py has those."""

    def pictures_after(self, paths):
        state, pictures = self.save(), []
        for path in paths:
            try:
                self.push(path)
                pictures.append(self.picture())
            except deformpush.WorldError:
                pictures.append(None)
            self.restore(state)
        return pictures

    monkeypatch.setattr(ToyWorld, "pictures_after", pictures_after)


@pytest.fixture(scope="module")
def abo(tmp_path_factory):
    return make(tmp_path_factory.mktemp("abo") / "run", "max_pushes=5", "optimizer.S0=2")


@pytest.fixture(scope="module")
def measured(abo, tmp_path_factory):
    """Files of regret of the run, in a folder of their own."""
    out = tmp_path_factory.mktemp("measured")
    true_regret.measure(RunFolder(abo), out, N)
    return out


def columns(folder, *flags):
    """What `regret` finds of a run, by column."""
    assert regret.main([str(folder), "--pushes", str(N), *flags]) == 0
    return {name: np.array(values) for name, values in read(folder / "regret.csv").items()}


def test_each_number_is_what_the_pushes_really_do(abo, measured):
    """Held against pushes made one by one, each in a world of its own."""
    run, rows = read_rows(abo / "pushes.csv"), read(measured / "regret.csv")
    tried = read_trials(measured / "regret_trials.csv")
    assert list(rows) == list(COLUMNS)
    assert rows["k"] == [1, 2, 3, 4, 5]
    assert tried["k"] == sorted(rows["k"] * N)
    U = np.column_stack([tried["kappa"], tried["d"]]).reshape(5, N, 2)
    np.testing.assert_array_equal(U[0], candidates(N, np.array([[0.0, 1.0], [0.01, 0.03]])))
    k, i = 4, 5
    episode = begun(setup(*TOY, "max_pushes=5", "optimizer.S0=2"))
    for row in run[1:k]:
        episode.push(u=np.array([row["kappa"], row["d"]]))
    forecast = episode.optimizer.predict(U[k - 1], episode.state)
    before = episode.record.errors.e_T
    xi = episode.push(u=U[k - 1, i]).errors.e_T - before
    at = (k - 1) * N + i
    assert tried["xi"][at] == xi
    assert (tried["xi_mean"][at], tried["xi_std"][at]) == (forecast[0][i], forecast[1][i])
    of_push = [tried["xi"][j] for j in range((k - 1) * N, k * N)]
    best = min(*of_push, run[k]["xi"])
    row = {name: values[k - 1] for name, values in rows.items()}
    assert (row["e_T_before"], row["xi"], row["xi_best"]) == (run[k - 1]["e_T"], run[k]["xi"], best)
    assert row["regret"] == run[k]["xi"] - best >= 0.0
    assert row["rank"] == 1 + sum(one < run[k]["xi"] for one in of_push)
    assert row["xi_tried"] == pytest.approx(np.mean(of_push))
    z = (np.array(of_push) - forecast[0]) / forecast[1]
    assert row["z_rms"] == pytest.approx(np.sqrt(np.mean(z**2)))
    assert row["inside_95"] == pytest.approx(np.mean(np.abs(z) <= 1.96))
    np.testing.assert_allclose(rows["cumulative_regret"], np.cumsum(rows["regret"]), rtol=1e-12)


def test_there_is_no_forecast_before_there_is_a_model(measured):
    rows = read(measured / "regret.csv")
    for name in ("xi_mean", "xi_std", "best_mean", "inside_95", "z_mean", "kendall_tau", "inference_regret"):
        assert np.isfinite(rows[name]).tolist() == [False, True, True, True, True], name
    assert rows["phase"][:2] == ["initial"] * 2
    assert np.isfinite(rows["regret"]).all()


def choosing(monkeypatch, pick):
    """The oracle chooses one of the pushes that `regret` tries, by what they do."""

    def choose(self, state):
        U = candidates(N, self.history.outer)
        return Proposal(U[pick(self._branches.e_T_after(U))], "exploit", self.history.outer)

    monkeypatch.setattr(Oracle, "_choose", choose)


@pytest.mark.parametrize(("pick", "rank"), [(np.nanargmin, 1), (np.nanargmax, N)])
def test_who_knows_the_best_push_has_no_regret_and_who_takes_the_worst_the_most(
    pick, rank, tmp_path, monkeypatch, capsys
):
    choosing(monkeypatch, pick)
    rows = columns(make(tmp_path / "run", "optimizer=oracle", "max_pushes=3"))
    tried = read_trials(tmp_path / "run" / "regret_trials.csv")
    worst = np.array(tried["xi"]).reshape(3, N).max(axis=1)
    assert (rows["rank"] == rank).all()
    np.testing.assert_array_equal(rows["regret"], 0.0 if rank == 1 else worst - rows["xi_best"])
    told = capsys.readouterr().out
    assert ("100% of what the best push would have gained" in told) == (rank == 1)
    assert "no forecasts" in told
    assert (tmp_path / "run" / "regret.png").read_bytes().startswith(b"\x89PNG" if rank == 1 else b"a figure")


@pytest.mark.parametrize("done", [0, 3])
def test_stopped_and_gone_on_with_it_is_the_same_file(done, abo, measured, tmp_path, monkeypatch, capsys):
    whole = true_regret.Walk._try
    line = [str(abo), "--pushes", str(N), "--out", str(tmp_path / "out")]

    def stop(self, U, made):
        if len(self.table.rows) == done:
            raise KeyboardInterrupt
        return whole(self, U, made)

    monkeypatch.setattr(true_regret.Walk, "_try", stop)
    with pytest.raises(KeyboardInterrupt):
        regret.main(line)
    assert "goes on" in capsys.readouterr().err
    assert len(read(tmp_path / "out" / "regret.csv")["k"]) == done
    with (tmp_path / "out" / "regret_trials.csv").open("a") as file:
        file.write(f"{done + 1},0.5,0.02,0.1,0.1,0.1\n{done + 1},0.5")  # killed in the middle of a push
    tries = []
    monkeypatch.setattr(true_regret.Walk, "_try", lambda *of: (tries.append(1), whole(*of))[1])
    assert regret.main(line) == 0
    assert len(tries) == 5 - done
    for name in FILES:
        assert (tmp_path / "out" / name).read_bytes() == (measured / name).read_bytes(), name
    tries.clear()
    assert regret.main(line) == 0
    assert not tries
    assert "5 of 5 pushes were there already" in capsys.readouterr().out


@pytest.mark.parametrize("optimizer", ["abo_motion", "random"])
def test_looking_on_changes_no_decision(optimizer, tmp_path, capsys):
    folder = make(tmp_path / "run", f"optimizer={optimizer}", "max_pushes=3")
    before = {name: (folder / name).read_bytes() for name in ("pushes.csv", "checkpoint.npz", "config.yaml")}
    rows = columns(folder)
    assert not capsys.readouterr().err
    assert {name: (folder / name).read_bytes() for name in before} == before
    assert np.isfinite(rows["z_rms"]).all() == (optimizer == "abo_motion")


def test_from_python_it_is_a_frame(tmp_path):
    folder = make(tmp_path / "run", "optimizer=greedy", "max_pushes=2")
    frame = deformpush.load(folder).regret(pushes=3)
    assert list(frame) == list(COLUMNS)
    assert frame["trials"].tolist() == [3, 3]
    assert frame.equals(deformpush.load(folder).regret(pushes=3))


def test_a_push_that_fails_is_counted_and_left_out(abo, tmp_path, monkeypatch, capsys):
    whole = ToyWorld.push

    alone = candidates(N, np.array([[0.0, 1.0], [0.01, 0.03]]))[3]

    def push(self, path):
        if path.d == alone[1]:
            raise deformpush.WorldError("it sticks")
        return whole(self, path)

    monkeypatch.setattr(ToyWorld, "push", push)
    out = tmp_path / "out"
    assert regret.main([str(abo), "--pushes", str(N), "--out", str(out)]) == 0
    rows, tried = read(out / "regret.csv"), read_trials(out / "regret_trials.csv")
    assert rows["failed"] == [1] * 5
    assert np.isnan(np.array(tried["xi"]).reshape(5, N)[:, 3]).all()
    assert np.isfinite(rows["xi_tried"]).all()
    assert "failed:      5 of 40 trials" in capsys.readouterr().out


def test_pushes_are_tried_as_fast_as_the_one_was_made(abo, tmp_path, monkeypatch):
    speeds, whole = [], ToyWorld.pictures_after
    monkeypatch.setattr(
        ToyWorld, "pictures_after", lambda self, p: (speeds.extend(x.speed for x in p), whole(self, p))[1]
    )
    folder = tmp_path / "run"
    shutil.copytree(abo, folder)
    lines = (folder / "pushes.csv").read_text().splitlines()
    at = lines[0].split(",").index("speed")
    cells = lines[2].split(",")
    cells[at] = "0.05"
    lines[2] = ",".join(cells)
    (folder / "pushes.csv").write_text("\n".join(lines) + "\n")
    columns(folder)
    assert speeds == [0.05] * N + [None] * 4 * N


def test_a_decision_that_is_another_now_is_told_of(abo, tmp_path, monkeypatch, capsys):
    shutil.copytree(abo, tmp_path / "run")
    config = tmp_path / "run" / "config.yaml"
    config.write_text(re.sub(r"(?m)^  w: .*$", "  w: 30.0", config.read_text()))
    columns(tmp_path / "run")
    assert "the optimizer now chooses" in capsys.readouterr().err


def test_a_run_that_does_not_repeat_itself_keeps_what_was_measured(abo, measured, tmp_path, monkeypatch):
    shutil.copytree(abo, tmp_path / "run")
    table = tmp_path / "run" / "pushes.csv"
    lines = table.read_text().splitlines(keepends=True)
    e_T = lines[0].split(",").index("e_T")
    cells = lines[3].split(",")
    cells[e_T] = "1.2345"
    table.write_text("".join([*lines[:3], ",".join(cells), *lines[4:]]))
    with pytest.raises(TroubleError, match="push 2 does not repeat itself"):
        columns(tmp_path / "run")
    assert (tmp_path / "run" / "regret.csv").read_bytes() == b"".join(
        (measured / "regret.csv").read_bytes().splitlines(keepends=True)[:2]
    )


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ("--pushes 0", "pushes = 0: must be 1 to "),
        ("--pushes 9", r"regret.csv: holds 8 trials a push, not 9; --overwrite begins again, --out"),
    ],
)
def test_mistakes_are_one_line(flags, message, abo, measured, tmp_path):
    for name in FILES:
        shutil.copy(measured / name, tmp_path / name)
    with pytest.raises(UserError, match=message) as caught:
        regret.main([str(abo), "--out", str(tmp_path), *flags.split()])
    assert "\n" not in caught.value.line
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (measured / name).read_bytes()


def test_files_of_another_run_are_refused_and_stay(measured, tmp_path):
    other = make(tmp_path / "run", "optimizer=random", "max_pushes=1")
    for name in FILES:
        shutil.copy(measured / name, other / name)
    line = [str(other), "--pushes", str(N)]
    with pytest.raises(UserError, match=r"row 1 is not of .*; --overwrite begins again"):
        regret.main(line)
    assert (other / "regret.csv").read_bytes() == (measured / "regret.csv").read_bytes()
    (other / "regret.csv").unlink()
    with pytest.raises(UserError, match=r"holds regret_trials.csv without the file that belongs to it"):
        regret.main(line)
    assert regret.main([*line, "--overwrite"]) == 0
    assert len(read(other / "regret.csv")["k"]) == 1


def test_a_world_without_branches_and_a_run_without_pushes_are_refused(abo, tmp_path, monkeypatch):
    monkeypatch.setattr(ToyWorld, "offers", ToyWorld.offers - {"branches"})
    with pytest.raises(UserError, match=r"^world=toy: offers no branches, which regret needs"):
        regret.main([str(abo), "--out", str(tmp_path)])
    assert not (tmp_path / "regret.csv").exists()
    shutil.copytree(abo, tmp_path / "run")
    table = tmp_path / "run" / "pushes.csv"
    table.write_bytes(b"".join(table.read_bytes().splitlines(keepends=True)[:2]))
    with pytest.raises(UserError, match="holds no push"):
        regret.main([str(tmp_path / "run")])
    with pytest.raises(UserError, match="no such folder"):
        regret.main([str(tmp_path / "nothing")])
