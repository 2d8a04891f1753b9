"""Every option of every config group composes, says what it is, gives every setting and builds."""

import inspect
import typing
from importlib.util import find_spec
from typing import Any

import pytest

from deformpush.config import build as config
from deformpush.config import schema as hints
from deformpush.config.groups import conf_dir, option_groups
from deformpush.config.locate import locate
from deformpush.errors import UserError
from deformpush.experiment.assemble import build_optimizer
from deformpush.experiment.setup import PLAIN, Setup, read
from deformpush.record.saved_config import read_config

GROUPS = option_groups()
CHOICES = [f"{group}={option}" for group, options in GROUPS.items() for option in options]
PACKAGES = {"acquisition": "acq", "stop": "task.stop", "experiment": "_global_"}
RIVAL_LIBRARIES = {
    "botorch": "botorch",
    "botorch_default": "botorch",
    "cmaes": "cmaes",
    "optuna_gp": "optuna",
}
NEEDS = {f"acquisition={name}": ["object=fish_fillet"] for name in ("safe_lcb", "safe_ei")}
"""Options that make no sense with the defaults of the other groups."""
AT_RUN_TIME = {"optimizer": {"parts"}}


def components(node: Any, key: str = "") -> list[tuple[str, dict[str, Any]]]:
    """Full key and settings of every `_target_` node."""
    if not isinstance(node, dict):
        return []
    here = [(key, node)] if "_target_" in node else []
    return here + [c for name, value in node.items() for c in components(value, f"{key}.{name}".lstrip("."))]


@pytest.mark.parametrize("choice", CHOICES)
def test_every_option_gives_every_setting_and_builds(choice, composed):
    cfg = composed(choice, *NEEDS.get(choice, []))
    group = choice.partition("=")[0]
    changed = {"acquisition": ["acq"], "stop": ["task"]}.get(group, [group])
    nodes, made = config.plain(cfg), read(cfg)
    if group in ("experiment", "optimizer"):  # these may reach into other groups
        changed = list(Setup.GROUPS)
    for key in changed:
        settings_are_complete_and_typed({key: nodes[key]})
        if key == "optimizer":
            optimizer_can_be_built(made)
        else:
            assert type(getattr(made, key)).__module__.startswith("deformpush.")


def optimizer_can_be_built(made: Setup) -> None:
    """Or a rival whose library is not installed says which extra brings it."""
    library = RIVAL_LIBRARIES.get(made.options["optimizer"])
    if library and find_spec(library) is None:
        with pytest.raises(UserError, match=r"pip install 'deformpush\[rivals\]' brings it$"):
            build_optimizer(made)
    else:
        assert callable(build_optimizer(made).ask)


def settings_are_complete_and_typed(cfg: dict[str, Any]) -> None:
    """Every argument of a component stands in the YAML, so that a reader sees it, and has a type to check."""
    for key, node in components(cfg):
        cls = locate(node["_target_"], key)
        known = typing.get_type_hints(cls, include_extras=True)
        settings = set(inspect.signature(cls).parameters) - AT_RUN_TIME.get(key, set())
        assert settings == set(node) - {"_target_"}, key
        assert not [name for name in settings if known[name] is Any], key


@pytest.mark.parametrize("choice", CHOICES)
def test_every_file_says_first_where_it_belongs_and_what_it_is(choice):
    group, option = choice.split("=")
    lines = (conf_dir() / group / f"{option}.yaml").read_text(encoding="utf-8").splitlines()
    header = next((line.split()[-1] for line in lines if line.startswith("# @package")), None)
    assert header in {PACKAGES.get(group), "_global_" if group == "optimizer" else PACKAGES.get(group)}
    assert any(line.startswith("# ") and "@package" not in line for line in lines[:2])


def test_the_default_configuration_passes_the_check_and_lists_all_groups(composed):
    config.check(config.plain(composed()))
    assert set(composed()[config.OPTIONS]) == set(GROUPS)


def test_the_components_of_a_run_are_the_groups_of_the_configuration(composed):
    assert {*Setup.GROUPS, *PLAIN} - {"values"} == set(composed())
    assert set(config.PLAIN) < set(PLAIN)


def test_a_class_of_another_group_is_refused(composed):
    for key, target in {"world": "gp.means.Zero", "acq": "gp.means.Zero", "optimizer": "gp.fit.MAP"}.items():
        cfg = composed()
        cfg[key] = {"_target_": f"deformpush.{target}"}
        with pytest.raises(UserError, match=rf"^{key}\._target_ = deformpush\.{target}: must be an? "):
            read(cfg)


def test_both_spellings_of_the_acquisition_work(composed):
    cfg = composed("acquisition=lcb", "acq.w=3.5")
    assert config.build(cfg.acq).w == 3.5


def test_the_command_line_wins_over_an_experiment_and_that_over_the_groups(composed):
    assert composed("experiment=paper_meat")[config.OPTIONS].object == "meat"
    assert composed("experiment=paper_meat", "object=rect")[config.OPTIONS].object == "rect"
    assert composed("experiment=paper_meat", "max_pushes=33").max_pushes == 33


def test_a_saved_configuration_is_whole(composed, tmp_path):
    cfg = composed("object=meat", "acq.w=1e-3", "hydra/launcher=basic")
    file = tmp_path / "config.yaml"
    file.write_text(read(cfg).yaml, encoding="utf-8")
    assert "${" not in file.read_text(encoding="utf-8")
    loaded = read_config(file)
    assert loaded == config.plain(cfg)
    assert config.build(loaded["object"], "object") == config.build(cfg.object)


def test_ranges_are_told_in_words():
    from typing import Annotated, Literal

    from annotated_types import Ge, Gt, Interval, Lt, MinLen

    words = {
        Annotated[float, Ge(0)]: "a number of 0 or more",
        Annotated[float, Gt(0)]: "a number above 0",
        Annotated[float, Ge(0), Lt(0.5)]: "a number in [0, 0.5)",
        Annotated[int, Interval(ge=64, le=2048)]: "a whole number in [64, 2048]",
        Annotated[float, Gt(0)] | None: "a number above 0 or null",
        Literal["all", "any"]: "all or any",
        tuple[float, float]: "[a number, a number]",
        Annotated[tuple[int, ...], MinLen(3)]: "a list, each item a whole number (at least 3 of them)",
        bool: "true or false",
    }
    assert {hint: hints.describe(hint) for hint in words} == words
