"""A replay says `identical`, or where the runs part."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from deformpush.cli import replay
from deformpush.errors import UserError
from deformpush.experiment import run
from deformpush.experiment.run import make_run
from deformpush.record.table import read
from deformpush.worlds.toy import ToyWorld
from tests.setups import setup

RUN = setup("world=toy", "robot=tool", "record=off", "max_pushes=12", "seed=2", "task.goal.offset=[0,0.3]")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "run"
    make_run(RUN, folder)
    return folder


def test_a_run_repeats_itself(made, capsys):
    before = {file.name: file.stat().st_mtime_ns for file in made.iterdir()}
    assert replay.main([str(made)]) == 0
    assert capsys.readouterr().out == "identical: 12 pushes, errors and contours to the last bit\n"
    assert {file.name: file.stat().st_mtime_ns for file in made.iterdir()} == before


def test_a_run_that_was_cut_is_replayed_as_far_as_it_goes(made, tmp_path, capsys):
    shutil.copytree(made, tmp_path / "run")
    rows = (made / "pushes.csv").read_text().splitlines(keepends=True)
    (tmp_path / "run" / "pushes.csv").write_text("".join(rows[:5]))
    (tmp_path / "run" / "summary.json").unlink()
    assert replay.main([str(tmp_path / "run")]) == 0
    assert capsys.readouterr().out == "identical: 3 pushes, errors and contours to the last bit\n"


def test_a_run_of_a_version_without_strain_is_replayed(made, tmp_path):
    shutil.copytree(made, tmp_path / "run")
    rows = (made / "pushes.csv").read_text().splitlines()
    (tmp_path / "run" / "pushes.csv").write_text("".join(",".join(r.split(",")[:23]) + "\n" for r in rows))
    assert replay.main([str(tmp_path / "run")]) == 0


def test_a_world_that_changed_is_noticed_with_place_and_size(made, capsys, monkeypatch):
    whole, calls = ToyWorld.push, []

    def push(self, path):
        outcome = whole(self, path)
        calls.append(1)
        if len(calls) == 4:
            self.c = np.add(self.c, (0.002, 0.0))
        return outcome

    monkeypatch.setattr(ToyWorld, "push", push)
    assert replay.main([str(made)]) == 1
    out = capsys.readouterr().out
    assert out.startswith("differs really, first at push 4: the contour by ")
    apart = float(out.split("the contour by ")[1].split(" mm")[0])
    assert apart >= 1.5
    assert out.splitlines()[-1].startswith("made with ")


def test_a_number_of_the_record_that_was_changed_is_noticed(made, tmp_path, capsys):
    shutil.copytree(made, tmp_path / "run")
    table = tmp_path / "run" / "pushes.csv"
    rows = table.read_text().splitlines()
    cells = rows[7].split(",")
    e_T = float(cells[8])
    cells[8] = repr(np.nextafter(e_T, 1.0).item())
    rows[7] = ",".join(cells)
    table.write_text("\n".join(rows) + "\n")
    assert replay.main([str(tmp_path / "run")]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"differs in the last bit, first at push 6: e_T is {e_T!r} and was {cells[8]}")
    assert lines[0].endswith("; grows no further in 12 pushes")
    assert lines[1] == "decides the same at every push"


def test_an_optimizer_that_changed_is_told_apart_from_the_world(made, capsys, monkeypatch):
    whole = run.build_optimizer

    def build(made):
        return whole(replace(made, acq=replace(made.acq, w=5.0)))

    monkeypatch.setattr(run, "build_optimizer", build)
    assert replay.main([str(made)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "identical: 12 pushes, errors and contours to the last bit"
    assert lines[1].startswith("decides otherwise: really, first at push 11")


def test_it_may_record_more_than_the_original_did(made, tmp_path, capsys):
    into = tmp_path / "again"
    assert replay.main([str(made), "--into", str(into), "record=light", "record.figures=false"]) == 0
    assert (into / "recording.rrd").stat().st_size > 10_000
    same = [
        read(path / "pushes.csv").drop(columns=["step_s", "render_s", "decide_s", "record_s"])
        for path in (made, into)
    ]
    assert same[0].equals(same[1])
    assert json.loads((into / "summary.json").read_text())["reason"] == f"replay of {made}, 12 pushes"


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["nowhere"], "nowhere: no such folder"),
        (["{run}", "record=full"], "record=full: recording needs --into FOLDER"),
        (["{run}", "--into", "{new}", "seed=4"], "seed=4: a replay changes nothing but record=OPTION"),
        (["{run}", "--into", "{run}"], "already holds results"),
    ],
)
def test_mistakes_are_one_line(argv, message, made, tmp_path):
    with pytest.raises(UserError, match=message) as caught:
        replay.main([text.format(run=made, new=tmp_path / "new") for text in argv])
    assert "\n" not in str(caught.value)
