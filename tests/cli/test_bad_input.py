"""Settings of any kind: a run is put up, or one line says why not, and nothing is left behind."""

import random
import time
from copy import deepcopy

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig, OmegaConf

from deformpush.config.compose import compose
from deformpush.config.groups import package
from deformpush.errors import UserError
from deformpush.experiment.run import make_run
from deformpush.experiment.setup import read
from tests.cli.test_cli import cli as command_line_in_process
from tests.fuzz_overrides import first_push, tried
from tests.overrides import command_line, setting
from tests.setups import setup

cli = command_line_in_process
TOY = ("world=toy", "robot=tool", "record=off")


@pytest.fixture(scope="module")
def toy():
    return compose(TOY)


@pytest.mark.parametrize("first", range(0, 120, 20))
def test_any_value_of_any_setting_is_taken_or_refused_in_one_line(first, toy):
    said = [complaint(toy, setting(random.Random(number), TOY)) for number in range(first, first + 20)]
    assert any(said)
    assert not any("\n" in line for line in said)


def complaint(toy, text: str) -> str:
    """What is said of a run with another setting; nothing if it can be put up and makes a push."""
    key, _, value = text.lstrip("+~").partition("=")
    changed, began = deepcopy(toy), time.process_time()
    parent, _, name = key.rpartition(".")
    node = OmegaConf.select(changed, parent, default=None) if parent else changed
    if not isinstance(node, DictConfig):
        return f"{key}: Hydra refuses it"
    node[name] = OverridesParser.create().parse_override(f"a={value or 'null'}").value()
    said = ""
    try:
        first_push(read(changed))
    except UserError as error:
        said = str(error)
    assert not said or time.process_time() - began < 2
    return said


@pytest.mark.parametrize("number", range(1, 5))
def test_any_command_line_is_a_run_or_one_line(number):
    became, said = tried(command_line(random.Random(number)))
    assert became != "wrong", said


@pytest.mark.slow
@pytest.mark.parametrize("number", range(1000, 1300))
def test_many_command_lines_are_runs_or_one_line(number):
    became, said = tried(command_line(random.Random(number)))
    assert became != "wrong", said


@pytest.mark.parametrize("folder", ["runs/2020-01-01/mine", "there"])
def test_a_refused_run_leaves_none_of_the_folders_made_for_it(folder, cli, tmp_path):
    (tmp_path / "runs").mkdir()
    assert cli(f"hydra.run.dir={folder}", "seed=-1").code == 2
    assert [path.name for path in tmp_path.rglob("*")] == ["runs"]


def test_an_empty_folder_of_the_users_stays(cli, tmp_path):
    (tmp_path / "there").mkdir()
    assert cli("hydra.run.dir=there", "seed=-1").code == 2
    assert (tmp_path / "there").is_dir()


def test_a_sweep_writes_nowhere_but_into_its_folder(cli, tmp_path):
    answer = cli("-m", "seed=1,2", "world=toy", "hydra.sweep.subdir=..")
    assert answer.err.startswith("hydra.sweep.subdir = ..: must stay ")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert not list(tmp_path.iterdir())


def test_a_start_that_explodes_is_refused_with_its_reason(cli, tmp_path):
    answer = cli("object.material.youngs_modulus=1e9", "robot=tool")
    assert answer.err.startswith("world=bullet: the simulation exploded")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert not list(tmp_path.iterdir())


def test_the_key_of_a_group_is_read_from_its_files():
    assert [package(group) for group in ("acquisition", "stop", "kernel")] == ["acq", "task.stop", "kernel"]


def test_a_safe_acquisition_needs_a_world_that_tells_strain(cli, tmp_path):
    answer = cli("acquisition=safe_lcb", "object=fish_fillet", "world=toy")
    assert answer.err.startswith("world=toy: offers no strain, which optimizer=abo with ")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert not list(tmp_path.iterdir())


def test_an_endless_argument_is_refused_at_once(cli, tmp_path):
    answer = cli(f"object.outline=[{'[0.1,0.1],' * 5000}[0,0]]")
    assert answer.err.startswith("object.outline=[[0.1,0.1],[0.1,0.1],[0.1...: has 50")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert not list(tmp_path.iterdir())


def test_a_clockwise_outline_is_reversed_and_that_is_said(tmp_path, caplog):
    rect = "object.outline=[[-.1,-.05],[-.1,.05],[.1,.05],[.1,-.05]]"
    make_run(setup(*TOY, rect, "robot=tool", "record=off", "max_pushes=10"), tmp_path / "run")
    assert "object.outline: runs clockwise; it is taken the other way round" in caplog.messages


def test_a_safe_acquisition_needs_a_limit(cli, tmp_path):
    answer = cli("acquisition=safe_lcb")
    assert answer.err.startswith("acq.limit: a safe acquisition needs one; ")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert not list(tmp_path.iterdir())
