"""Every option of the optimizer's config groups builds, and the YAML and the code name the same defaults."""

import dataclasses
import importlib
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from hydra import compose, initialize_config_dir
from omegaconf import DictConfig

from deformpush.config import default_world
from deformpush.optimizer import EI, LCB, Components
from tests.states import seen

CONF = Path(__file__).parents[2] / "conf"
GROUPS = ("kernel", "mean", "fit", "model", "acquisition", "bounds", "design", "minimiser", "optimizer")
OPTIONS = [(group, path.stem) for group in GROUPS for path in sorted((CONF / group).glob("*.yaml"))]
DEFAULTS = {
    "kernel": "matern52",
    "mean": "zero",
    "fit": "map",
    "model": "error",
    "acquisition": "lcb",
    "bounds": "adaptive",
    "design": "lhs",
    "minimiser": "adam",
    "optimizer": "abo",
}


def composed(*overrides):
    default_world.register()
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return compose("config", overrides=list(overrides))


def constructed(node, **runtime):
    fields = {k: constructed(v) if isinstance(v, dict | DictConfig) else v for k, v in dict(node).items()}
    module, name = fields.pop("_target_").rsplit(".", 1)
    kind = getattr(importlib.import_module(module), name)
    named = {f.name for f in dataclasses.fields(kind) if f.init} - set(runtime)
    assert set(fields) == named, "the YAML gives every field a value, and no other"
    return kind(**fields, **runtime)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("group", "option"), OPTIONS, ids=[f"{g}={o}" for g, o in OPTIONS])
def test_every_option_asks_for_a_push(group, option):
    if option in ("botorch", "botorch_default", "optuna_gp", "cmaes"):
        pytest.importorskip("botorch", reason="extra `rivals` is not installed")
    limit = ["object.strain_limit=0.1"] if option.startswith("safe_") else []
    config = composed(f"{group}={option}", "object.d=[0.01,0.03]", *limit)
    parts = {
        name: constructed(config[name])
        for name in ("kernel", "mean", "fit", "model", "bounds", "design", "minimiser")
    }
    parts |= {"acquisition": constructed(config.acq), "rng": np.random.default_rng(0)}
    if option == "rigid_push":
        with pytest.raises(ValueError, match=r"mean: rigid_push .* model=motion"):
            constructed(config.optimizer, parts=Components(**parts))
        parts["model"] = constructed(composed("model=motion").model)
    opt = constructed(config.optimizer, parts=Components(**parts, closed=True))
    opt.attach(SimpleNamespace(e_T_after=lambda U: np.sin(9.0 * U[:, 0])))
    for t in range(opt.S0 + 1):
        before, after = seen(y=0.005 * t), seen(y=0.005 * t + 0.005)
        u = opt.ask(before).u
        opt.tell(u, -float(u[0]) * np.cos(t), before, after)
    assert opt.ask(after).phase in ("explore", "exploit")


@pytest.mark.parametrize("group", [g for g in GROUPS if g not in ("bounds", "optimizer")])
def test_code_and_configuration_agree_on_the_default(group):
    node = composed(f"{group}={DEFAULTS[group]}")["acq" if group == "acquisition" else group]
    built = constructed(node)
    defaults = type(built)()
    for field in dataclasses.fields(built):
        value = getattr(built, field.name)
        value = tuple(value) if not isinstance(value, (str, float, int)) else value
        assert value == getattr(defaults, field.name), field.name


def test_parts_default_to_the_configured_defaults():
    config = composed()
    parts = Components(bounds=None, rng=None)
    for name in ("kernel", "mean", "fit", "model", "design", "minimiser"):
        assert type(getattr(parts, name)) is type(constructed(config[name]))
    assert type(parts.acquisition) is type(constructed(config.acq))


@pytest.mark.parametrize("path", sorted((CONF / "acquisition").glob("*.yaml")), ids=lambda p: p.stem)
def test_acquisitions_share_one_package(path):
    assert path.read_text().startswith("# @package acq\n")
    assert "_target_" in yaml.safe_load(path.read_text())


@pytest.mark.parametrize("w", [1.0, 0.0])
def test_the_weight_of_safe_lcb_is_that_of_its_inner_acquisition(w):
    config = composed("acquisition=safe_lcb", f"acq.w={w}", "object.strain_limit=0.1")
    assert constructed(config.acq).inner == LCB(w=w)
    preset = composed("optimizer=abo_motion", "acquisition=safe_lcb", "object.strain_limit=0.1")
    assert constructed(preset.acq).inner == LCB(w=0.5)


def test_the_presets_of_a_safe_acquisition_differ_in_the_inner_one_alone():
    lcb, ei = (
        constructed(composed(f"acquisition={name}", "object.strain_limit=0.1").acq)
        for name in ("safe_lcb", "safe_ei")
    )
    settings = {f.name for f in dataclasses.fields(ei)} - {"inner"}
    assert {name: getattr(lcb, name) for name in settings} == {name: getattr(ei, name) for name in settings}
    assert (type(lcb.inner), type(ei.inner)) == (LCB, EI)


def test_the_command_line_wins_over_a_preset():
    config = composed("optimizer=tv_gp_ucb", "acquisition=ei", "kernel=rbf", "kernel.eps=0.1")
    assert config.acq._target_.endswith(".EI")
    assert config.kernel._target_.endswith(".SquaredExponential")
    assert (config.kernel.time, config.kernel.eps) == ("tv", 0.1)


def test_importing_the_optimizer_loads_nothing_heavy():
    heavy = "{'torch', 'scipy', 'cv2', 'hydra', 'omegaconf', 'pybullet', 'rerun', 'pandas', 'matplotlib'}"
    code = f"import sys, deformpush.optimizer; print({heavy} & set(sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "set()"
