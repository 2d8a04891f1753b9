"""The contract of worlds: every world keeps it, also one of a user's, and what breaks it is told where."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deformpush.cell.world import Outcome, Scenery, Strain, WorldError
from deformpush.checks.contract import contract
from deformpush.config import locate
from deformpush.config.locate import use_config_dir
from deformpush.errors import UserError
from deformpush.record.table import read
from deformpush.worlds.toy import ToyWorld
from tests.worlds.mine import BARE, WORLD, own_folder

ROOT = Path(__file__).resolve().parents[2]
TOY = ["world=toy", "robot=tool"]
ALWAYS = ["picture", "can_reach", "nodes, strain, scenery", "push", "push out of reach"]
WITH_BRANCHES = [*ALWAYS[:4], "branches", *ALWAYS[4:]]
WITH_STATES = [*ALWAYS[:4], "branches", "states", *ALWAYS[4:]]


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A user's own folder; nothing of it stays in this process."""
    monkeypatch.setattr(locate, "_trusted", [])
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield own_folder(tmp_path / "conf_mine")
    for name in ("my_world", "bare_world"):
        sys.modules.pop(name, None)


def verdicts(overrides) -> dict[str, bool]:
    return {gate.name: gate.passed for gate in contract(overrides)}


@pytest.mark.parametrize(
    ("overrides", "gates"),
    [
        (TOY, WITH_STATES),
        ([*TOY, "object=meat", "task.jitter=true", "seed=3"], WITH_STATES),
        pytest.param(["world=bullet", "robot=tool"], WITH_BRANCHES, marks=pytest.mark.slow),
        pytest.param(["world=bullet", "robot=kuka_iiwa"], WITH_BRANCHES, marks=pytest.mark.slow),
    ],
    ids=["toy", "toy, another object", "bullet", "bullet with an arm"],
)
def test_every_world_keeps_the_contract(overrides, gates):
    assert verdicts(overrides) == dict.fromkeys(gates, True)


@pytest.mark.parametrize("name", ["mine", "bare"])
def test_a_users_own_world_keeps_the_contract(name, own):
    assert WORLD.count("\n") <= 25
    assert BARE.count("\n") <= 25
    found = verdicts([f"world={name}", "robot=tool", use_config_dir(str(own))])
    assert found == dict.fromkeys(ALWAYS, True)


def small_picture(whole):
    return {"picture": lambda self: np.ascontiguousarray(whole.picture(self)[::2, ::2])}


def grey_picture(whole):
    return {"picture": lambda self: whole.picture(self)[:, :, 0]}


def picture_of_floats(whole):
    return {"picture": lambda self: whole.picture(self) / 255.0}


def push_that_does_nothing(whole):
    return {"push": lambda self, path: Outcome()}


def push_the_wrong_way(whole):
    def push(self, path):
        self.c = self.c - path.d * path.direction
        return Outcome(film=[self.nodes()])

    return {"push": push}


def push_that_says_nothing(whole):
    def push(self, path):
        whole.push(self, path)

    return {"push": push}


def push_that_always_fails(whole):
    def push(self, path):
        raise WorldError("the tool is broken")

    return {"push": push}


def strain_that_is_promised_and_not_measured(whole):
    return {"offers": frozenset({"strain"})}


def strain_of_pushes_that_is_promised_and_not_told(whole):
    return {"offers": frozenset({"strain"}), "strain": lambda self: np.zeros(len(self.nodes()))}


def strain_that_is_told_and_not_promised(whole):
    def push(self, path):
        return replace(whole.push(self, path), strain=Strain(0.1, 0.1, 0.1, 0.0))

    return {"push": push}


def film_that_is_promised_and_not_taken(whole):
    def push(self, path):
        return replace(whole.push(self, path), film=[])

    return {"push": push}


def strain_of_other_nodes(whole):
    return {"offers": frozenset({"strain"}), "strain": lambda self: np.zeros(7)}


def triangles_of_another_mesh(whole):
    return {"scenery": lambda self: Scenery(mesh_triangles=np.array([[0, 1, 10**6]]))}


def scenery_without_its_type(whole):
    return {"scenery": lambda self: {"mesh_triangles": None}}


def nodes_that_are_not_finite(whole):
    return {"nodes": lambda self: np.full((9, 3), np.nan)}


def push_out_of_reach_that_moves_the_object(whole):
    def push(self, path):
        self.c = self.c + path.d * path.direction
        return Outcome(film=[self.nodes()])

    return {"push": push, "can_reach": lambda self, points: np.abs(points[:, 0] - 0.58) < 0.6}


def refusal_after_the_object_has_moved(whole):
    def push(self, path):
        self.c = self.c + path.d * path.direction
        if not self.can_reach(path.end[None]).all():
            raise WorldError("out of reach")
        return Outcome(film=[self.nodes()])

    return {"push": push, "can_reach": lambda self, points: np.abs(points[:, 0] - 0.58) < 0.6}


def branches_that_disturb_the_world(whole):
    def pictures_after(self, paths):
        pictures = []
        for path in paths:
            whole.push(self, path)
            pictures.append(self.picture())
        return pictures

    return {"pictures_after": pictures_after}


def branches_of_which_none_grows(whole):
    return {"pictures_after": lambda self, paths: [None for _ in paths]}


def reach_of_nothing(whole):
    return {"can_reach": lambda self, points: np.zeros(len(points), bool)}


def reach_of_one_answer(whole):
    return {"can_reach": lambda self, points: True}


def reach_in_numbers(whole):
    return {"can_reach": lambda self, points: np.linalg.norm(points, axis=1)}


BROKEN = {
    small_picture: "picture",
    grey_picture: "picture",
    picture_of_floats: "picture",
    reach_of_one_answer: "can_reach",
    reach_in_numbers: "can_reach",
    strain_that_is_promised_and_not_measured: "nodes, strain, scenery",
    strain_of_other_nodes: "nodes, strain, scenery",
    triangles_of_another_mesh: "nodes, strain, scenery",
    scenery_without_its_type: "nodes, strain, scenery",
    nodes_that_are_not_finite: "nodes, strain, scenery",
    branches_that_disturb_the_world: "branches",
    branches_of_which_none_grows: "branches",
    push_that_does_nothing: "push",
    push_the_wrong_way: "push",
    push_that_says_nothing: "push",
    push_that_always_fails: "push",
    reach_of_nothing: "can_reach",
    strain_of_pushes_that_is_promised_and_not_told: "push",
    strain_that_is_told_and_not_promised: "push",
    film_that_is_promised_and_not_taken: "push",
    push_out_of_reach_that_moves_the_object: "push out of reach",
    refusal_after_the_object_has_moved: "push out of reach",
}


@pytest.mark.parametrize("breakage", BROKEN, ids=lambda breakage: breakage.__name__)
def test_a_world_that_breaks_the_contract_is_told_where(breakage, monkeypatch):
    """The gate that fails is the one that names the mistake, and those after it are not asked."""
    whole = type("Whole", (ToyWorld,), {name: vars(ToyWorld)[name] for name in ("push", "picture")})
    for name, value in breakage(whole).items():
        monkeypatch.setattr(ToyWorld, name, value)
    *passed, last = contract(TOY)
    assert (last.name, last.passed) == (BROKEN[breakage], False)
    gates = [name for name in WITH_STATES if name in {*ALWAYS, *ToyWorld.offers}]
    assert [(gate.name, gate.passed) for gate in passed] == [
        (name, True) for name in gates[: gates.index(last.name)]
    ]


def test_an_object_that_cannot_be_seen_is_one_line(monkeypatch):
    monkeypatch.setattr(ToyWorld, "picture", lambda self: np.full((480, 480, 3), 255, np.uint8))
    with pytest.raises(UserError, match=r"^world=toy: no object in the picture"):
        verdicts(TOY)


def test_the_world_is_closed_whatever_the_gates_say(monkeypatch):
    closed = []
    monkeypatch.setattr(ToyWorld, "close", lambda self: closed.append(1))
    monkeypatch.setattr(ToyWorld, "push", lambda self, path: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        verdicts(TOY)
    assert closed == [1]


def deformpush(folder: Path, *argv: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "deformpush", *argv]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)


def test_doctor_examines_a_users_own_world(own):
    done = deformpush(own.parent, "doctor", "world=mine", "--config-dir", own.name)
    assert (done.returncode, done.stderr) == (0, "")
    first, *rows, last = done.stdout.splitlines()
    assert first.split() == ["gate", "measured", "allowed"]
    assert [row[:24].strip() for row in rows] == ALWAYS
    assert all(row.endswith(" ok") for row in rows)
    assert last == "all gates hold"


def test_doctor_says_which_gate_fails(own):
    (own / "my_world.py").write_text(WORLD.replace("path.d * path.direction", "0.0"))
    done = deformpush(own.parent, "doctor", "world=mine", "--config-dir", own.name)
    assert (done.returncode, done.stderr) == (1, "")
    failed = [row for row in done.stdout.splitlines() if row.endswith(" FAILED")]
    assert [row.partition("  ")[0] for row in failed] == ["push"]
    assert "0.0 mm forward for 30 mm" in failed[0]
    assert done.stdout.endswith("a gate fails: do not trust numbers from this world\n")


@pytest.mark.parametrize(("name", "recording"), [("mine", "full"), ("bare", "off")])
def test_a_run_in_a_users_own_world(name, recording, own):
    """From folder to recording; and the pushes of a run can be made again."""
    settings = [f"world={name}", "robot=tool", "max_pushes=3", f"record={recording}", "hydra.run.dir=run"]
    done = deformpush(own.parent, "--config-dir", own.name, *settings, "optimizer=random")
    assert (done.returncode, done.stderr) == (0, "")
    run = own.parent / "run"
    assert json.loads((run / "summary.json").read_text())["pushes"] == 3
    assert read(run / "pushes.csv").k.tolist() == [0, 1, 2, 3]
    assert (run / "recording.rrd").exists() == (recording == "full")
    assert f"_target_: {'my' if name == 'mine' else name}_world." in (run / "config.yaml").read_text()
    again = deformpush(own.parent, "replay", "run", "--config-dir", own.name)
    assert (again.returncode, again.stderr) == (0, "")
    assert again.stdout.startswith("identical: 3 pushes")


def test_a_users_own_world_needs_its_folder_again(own):
    """Otherwise a folder of somebody else's would say what code is run."""
    settings = ["world=mine", "robot=tool", "max_pushes=1", "record=off", "hydra.run.dir=run"]
    assert deformpush(own.parent, "--config-dir", own.name, *settings, "optimizer=random").returncode == 0
    refused = deformpush(own.parent, "replay", "run")
    assert (refused.returncode, refused.stdout, refused.stderr.count("\n")) == (2, "", 1)
    assert "world._target_ = my_world.Mine: is not a class of deformpush" in refused.stderr


def test_what_only_some_worlds_offer_is_refused_in_one_line(own):
    for settings, missing in (
        (["optimizer=oracle"], "branches"),
        (["object=fish_fillet", "acquisition=safe_lcb"], "strain"),
    ):
        done = deformpush(own.parent, "--config-dir", own.name, "world=mine", "robot=tool", *settings)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert done.stderr.startswith(f"world=mine: offers no {missing}, which optimizer=")
    assert not list(own.parent.glob("runs/**/*.*"))
