"""A run may end with the first push that does harm, and harm is counted beside success."""

import json
from dataclasses import replace

import pytest

from deformpush.cell.world import Strain
from deformpush.experiment.run import make_run, resume
from deformpush.record.table import read
from deformpush.study.find_runs import find_runs
from deformpush.study.tables import caption, run_rows, variant_rows
from deformpush.study.variants import Variant, differing
from deformpush.worlds.toy import ToyWorld
from tests.setups import setup

TOY = ["world=toy", "robot=tool", "record=off", "optimizer=greedy", "seed=1", "object=fish_fillet"]


@pytest.fixture
def strained(monkeypatch):
    """The toy world, with a strain that grows by 0.03 with every push."""
    whole, calls = ToyWorld.push, []

    def push(self, path):
        calls.append(1)
        peak = 0.03 * len(calls)
        return replace(whole(self, path), strain=Strain(peak, peak / 2, 2 * peak, peak / 9, 0.1))

    monkeypatch.setattr(ToyWorld, "push", push)
    return calls


@pytest.fixture
def pressed(monkeypatch):
    """The toy world, with a tool that presses by 1 N more with every push; the object bears 2.5 N."""
    whole, calls = ToyWorld.push, []

    def push(self, path):
        calls.append(1)
        force = float(len(calls))
        return replace(whole(self, path), tool_force_peak=force, tool_force_mean=force / 2, force_limit=2.5)

    monkeypatch.setattr(ToyWorld, "push", push)


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def test_a_run_ends_as_damaged_only_on_request(strained, tmp_path, capsys):
    assert make_run(setup(*TOY, "task.stop.on_damage=true"), tmp_path / "a").status == "damaged"
    end = summary(tmp_path / "a")
    assert (end["status"], end["pushes"], end["exceedances"]) == ("damaged", 4, 1)
    assert end["reason"] == "push 4 strained the object to 0.12, its limit is 0.1"
    assert end["strain_peak"] == pytest.approx(0.12)
    assert end["strain_dose"] == pytest.approx(0.3)
    assert capsys.readouterr().out.startswith("damaged: ended the run after 4 pushes (push 4 strained")
    strained.clear()
    make_run(setup(*TOY), tmp_path / "b")
    end = summary(tmp_path / "b")
    assert end["status"] == "reached"
    assert end["pushes"] > 4
    assert end["exceedances"] == end["pushes"] - 3


def test_a_force_beyond_its_limit_is_damage_too(pressed, tmp_path, capsys):
    make_run(setup(*TOY, "task.stop.on_damage=true", "object.force_limit=2.5"), tmp_path / "a")
    end = summary(tmp_path / "a")
    assert (end["status"], end["pushes"], end["exceedances"]) == ("damaged", 3, 1)
    assert end["reason"] == "push 3 pressed on the object with 3 N, its limit is 2.5 N"
    assert (end["force_peak"], end["force_limit"], end["strain_peak"]) == (3.0, 2.5, None)
    assert read(tmp_path / "a" / "pushes.csv").tool_force_peak.tolist()[1:] == [1.0, 2.0, 3.0]
    assert "force:     3 N at most, of the tool (limit 2.5 N)" in capsys.readouterr().out


def test_the_table_says_which_pushes_did_harm(strained, tmp_path):
    make_run(setup(*TOY, "task.stop.on_damage=true"), tmp_path / "a")
    table = read(tmp_path / "a" / "pushes.csv")
    assert table.limit_exceeded.tolist()[1:] == [0, 0, 0, 1]
    assert table.strain_p99_peak.tolist()[1:] == pytest.approx([0.03, 0.06, 0.09, 0.12])


def test_a_damaged_run_is_finished(strained, tmp_path, capsys):
    make_run(setup(*TOY, "task.stop.on_damage=true"), tmp_path / "a")
    assert resume(tmp_path / "a") is None
    assert "nothing to resume, it ended: damaged after 4 pushes" in capsys.readouterr().out


def test_success_is_counted_with_and_without_damage(strained, tmp_path):
    for seed, (name, offset) in enumerate({"harmed": 0.2, "unharmed": 0.03}.items()):
        strained.clear()
        make_run(setup(*TOY, f"task.goal.offset=[0,{offset}]", f"seed={seed}"), tmp_path / name)
    runs = find_runs([tmp_path]).runs
    header, *rows = run_rows(runs, differing(runs))
    assert [int(row[header.index("harmful")]) > 0 for row in rows] == [True, False]
    both = [Variant("both", tuple(runs))]
    header, row = variant_rows(both)
    assert row[header.index("reached")] == "2"
    assert row[header.index("unharmed")] == "1"
    assert caption(both).endswith("no push went beyond a limit of the object.")


def test_without_a_limit_nothing_is_said_of_harm(tmp_path):
    make_run(setup("world=toy", "robot=tool", "record=off", "optimizer=greedy"), tmp_path / "run")
    runs = find_runs([tmp_path]).runs
    assert "harmful" not in run_rows(runs, differing(runs))[0]
    one = [Variant("one", tuple(runs))]
    assert "unharmed" not in variant_rows(one)[0]
    assert "harm" not in caption(one)
