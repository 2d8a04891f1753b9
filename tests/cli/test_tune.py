"""Tuning: ranges in Hydra's grammar, a study that can be stopped anywhere, and seeds kept for reporting."""

import csv
import json
import os
import signal
import time
from pathlib import Path

import pytest

from deformpush.cli import tune
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.run import make_run
from deformpush.experiment.tuning.cost import cost
from deformpush.experiment.tuning.space import parse
from deformpush.record.finished import flat
from deformpush.record.folder import RunFolder
from deformpush.record.lock import Lock
from deformpush.record.saved_config import read_config
from deformpush.record.table import read_rows
from tests.faults import in_child
from tests.setups import setup

pytest.importorskip("optuna")

TOY = ["world=toy", "robot=tool", "stop=strict", "max_pushes=12"]
ASKED = [
    "acq.w=tag(log, interval(0.5, 4))",
    "kernel=matern52,rbf",
    *TOY,
    "--seeds",
    "100-101",
    "--trials",
    "3",
]


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "tune.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Three trials of two runs, without an interruption."""
    folder = tmp_path_factory.mktemp("made") / "mine"
    assert tune.main([*ASKED, "--out", str(folder)]) == 0
    return folder


def test_each_trial_is_a_run_per_seed_with_its_settings(made):
    for row in rows(made):
        trial = made / f"trial-{int(row['trial']):03}"
        assert {item.name for item in trial.iterdir()} == {"seed=100", "seed=101"}
        made_with = flat(read_config(trial / "seed=101" / "config.yaml"))
        assert tuple(made_with[key] for key in ("seed", "acq.w", "options.kernel")) == (
            101,
            float(row["acq.w"]),
            row["kernel"],
        )
        costs = [cost(RunFolder(trial / name), 12) for name in ("seed=100", "seed=101")]
        assert float(row["objective"]) == pytest.approx(sum(costs) / 2)
        assert 0.5 <= float(row["acq.w"]) <= 4.0


def test_the_same_command_again_makes_nothing_and_more_trials_go_on(made, capsys):
    before = (made / "tune.csv").read_bytes()
    times = {file: file.stat().st_mtime_ns for file in made.rglob("summary.json")}
    assert tune.main([*ASKED, "--out", str(made)]) == 0
    out = capsys.readouterr().out
    assert "trial 0:" not in out
    best = min(rows(made), key=lambda row: float(row["objective"]))
    assert f"best: acq.w={best['acq.w']} kernel={best['kernel']}\n" in out
    assert (made / "tune.csv").read_bytes() == before
    assert {file: file.stat().st_mtime_ns for file in made.rglob("summary.json")} == times


def test_a_killed_tuning_goes_on_to_the_same_trials(tmp_path, made):
    folder = tmp_path / "mine"
    child = in_child(lambda: tune.main([*ASKED, "--out", str(folder)]))
    patience = time.monotonic() + 120
    while time.monotonic() < patience:
        begun = folder / "trial-001" / "seed=100" / "pushes.csv"
        if begun.exists() and begun.read_bytes().count(b"\n") >= 4:
            break
        time.sleep(0.005)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    assert len(rows(folder)) == 1
    finished = (folder / "trial-000" / "seed=101" / "summary.json").stat().st_mtime_ns
    assert tune.main([*ASKED, "--out", str(folder)]) == 0
    assert (folder / "tune.csv").read_text() == (made / "tune.csv").read_text()
    assert (folder / "trial-000" / "seed=101" / "summary.json").stat().st_mtime_ns == finished
    assert json.loads((folder / "trial-001" / "seed=100" / "summary.json").read_text())["resumed"] >= 2


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (
            ["acq.w=1,2", "--seeds", "3-5"],
            "--seeds 3-5: 3 is one of the seeds 0 to 19, ",
        ),
        (["acq.w=1,2", "--seeds", "x"], "--seeds x: must be numbers and ranges"),
        (["acq.w=1,2", "--seeds", "9-2"], "--seeds 9-2: names no seed"),
        (["acq.w=1,2", "--seeds", "100,100"], "names a seed twice"),
        (["acq.w=1,2", "--trials", "0"], "--trials 0: must be 1 or more"),
        (["acq.w=1"], "no range to tune"),
        (["acq.w=interval(4, 0.5)"], r"acq.w=interval\(4, 0.5\): no range"),
        (["acq.w=tag(log, interval(0, 2))"], "no range"),
        (["acq.w=glob(*)"], "not a range that can be tuned"),
        (["acq.w=("], "not KEY=VALUE"),
        (
            ["object.thickness=0.01,0.02"],
            "object.thickness=0.01,0.02: a range must be of the optimizer: acq, ",
        ),
        (["acq.w=1,2", "seed=3"], "seed=3: not in a tuning; --seeds says which"),
        (["acq.w=1,2", "hydra.run.dir=x"], "not in a tuning; --out names the folder"),
        (["acq.w=1,2", "object=fish"], "object=fish: no such option"),
    ],
)
def test_mistakes_are_one_line_before_anything_is_made(argv, message, tmp_path):
    with pytest.raises(UserError, match=message) as caught:
        tune.main([*argv, "--out", str(tmp_path / "mine")])
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "mine").exists()


def test_another_tuning_in_the_same_folder_is_refused(made):
    with pytest.raises(UserError, match="holds a tuning with other ranges") as caught:
        tune.main(["acq.w=1,2", *TOY, "--seeds", "100-101", "--out", str(made)])
    assert "\n" not in str(caught.value)
    lock = Lock.take(made)
    with pytest.raises(UserError, match="another process is at work in this folder"):
        tune.main([*ASKED, "--out", str(made)])
    lock.release()


def test_a_damaged_study_is_one_line(tmp_path):
    (tmp_path / "study.db").write_bytes(b"not a database" * 100)
    with pytest.raises(TroubleError, match=r"study.db: cannot be used as a study: ") as caught:
        tune.main([*ASKED, "--out", str(tmp_path)])
    assert "\n" not in str(caught.value)


def test_a_choice_that_does_not_fit_is_refused_and_the_others_go_on(tmp_path, capsys):
    argv = ["optimizer.S0=5,99", *TOY, "--seeds", "100", "--trials", "4", "--out", str(tmp_path / "mine")]
    assert tune.main(argv) == 0
    found = {row["optimizer.S0"]: row for row in rows(tmp_path / "mine")}
    assert set(found) == {"5", "99"}
    assert found["99"]["reason"].startswith("optimizer.S0 = 99: must not exceed the budget max_pushes = 12")
    assert found["99"]["objective"] == ""
    assert "best: optimizer.S0=5\n" in capsys.readouterr().out


def test_what_a_run_costs(tmp_path):
    """Arrived: its pushes. Else more than the budget, by how far away it is. Failed: twice the budget."""
    make_run(setup(*TOY, "record=off", "optimizer=random", "max_pushes=4"), tmp_path / "run")
    folder = RunFolder(tmp_path / "run")
    end = json.loads(folder.summary.read_text())
    e_T = [row["e_T"] for row in read_rows(folder.table)]
    assert cost(folder, 4) == 4 * (1 + min(1, e_T[-1] / e_T[0]))
    folder.summary.write_text(json.dumps({**end, "status": "reached"}))
    assert cost(folder, 4) == 4
    folder.summary.write_text(json.dumps({**end, "status": "failed"}))
    assert cost(folder, 4) == 8
    folder.summary.unlink()
    with pytest.raises(TroubleError, match="did not come to its end"):
        cost(folder, 4)


def test_ranges_are_those_of_hydra():
    space = parse(
        ["optimizer.S0=int(interval(3, 9))", "kernel.rho_t=range(5, 30, 5)", "acq.w=0.5,2", "object=meat"]
    )
    made = {key: type(one).__name__ for key, one in space.ranges.items()}
    assert made == {
        "optimizer.S0": "IntDistribution",
        "kernel.rho_t": "IntDistribution",
        "acq.w": "CategoricalDistribution",
    }
    assert (space.ranges["kernel.rho_t"].low, space.ranges["kernel.rho_t"].high) == (5, 25)
    assert space.fixed == ("record=off", "object=meat")
    assert space.overrides({"acq.w": "0.5", "optimizer.S0": 4})[-2:] == ["acq.w=0.5", "optimizer.S0=4"]
