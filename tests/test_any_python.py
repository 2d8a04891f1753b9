"""What runs on a Python that PyBullet has no wheel for, and without torch.

In child processes that cannot find either, whether installed or not.
"""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

from deformpush.config import default_world
from deformpush.config.compose import compose
from tests.house_rules import PACKAGE, ROOT, modules

MAKEFILE = (ROOT / "Makefile").read_text()
WITHOUT = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"pybullet", "pybullet_data", "pybullet_utils", "torch"}:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name.split(".")[0])

sys.meta_path.insert(0, Absent())
import importlib.util
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: None if "pybullet" in name else found(name, package)
"""


def child(code: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-c", WITHOUT + code], capture_output=True, text=True, cwd=cwd, env=environment
    )


def deformpush(cwd: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return child(f"sys.argv[1:] = {arguments!r}\nfrom deformpush.__main__ import main\nmain()", cwd)


def test_every_module_can_be_imported(tmp_path):
    names = [".".join(("deformpush", *path)).removesuffix(".__init__") for path in modules(PACKAGE)]
    names = [name for name in names if not name.endswith("__main__") and "hydra_plugins" not in name]
    done = child(f"import importlib\nfor name in {names!r}: importlib.import_module(name)", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_run_that_names_no_world_takes_mujoco_and_says_so_and_abo_motion_needs_no_torch(tmp_path):
    quick = ("optimizer=abo_motion", "robot=tool", "object.cell=0.02", "max_pushes=2", "record=off")
    done = deformpush(tmp_path, *quick, "hydra.run.dir=here")
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stderr.splitlines() if "PyBullet" in line]
    assert told == ["world=mujoco: PyBullet, the default, is not installed here; world=... chooses"]
    config = yaml.safe_load((tmp_path / "here" / "config.yaml").read_text())
    assert config["options"]["world"] == "mujoco"
    assert config["world"]["_target_"].startswith("deformpush.worlds.mujoco.")
    summary = json.loads((tmp_path / "here" / "summary.json").read_text())
    assert summary["pushes"] == 2


@pytest.mark.parametrize(
    ("overrides", "world"), [([], "mujoco"), (["world=bullet"], "bullet"), (["world=toy"], "toy")]
)
def test_whoever_names_a_world_gets_it(overrides, world, monkeypatch):
    monkeypatch.setattr(default_world, "find_spec", lambda name: None)
    assert compose(overrides).options.world == world


@pytest.mark.parametrize(
    ("overrides", "experiment", "told"),
    [([], "mujoco", 1), (["seed=1"], "mujoco", 1), (["world=mujoco"], "mujoco", 0), ([], "toy", 0)],
)
def test_it_is_said_where_no_one_chose(overrides, experiment, told, monkeypatch, capsys):
    monkeypatch.setattr(default_world, "find_spec", lambda name: None)
    default_world._tell.cache_clear()
    for _ in range(2):
        default_world.tell_default({"world": experiment}, overrides)
    assert capsys.readouterr().err.count("PyBullet") == told


def test_where_bullet_is_installed_nothing_changes(monkeypatch, capsys):
    monkeypatch.setattr(default_world, "find_spec", lambda name: object())
    assert default_world.default_world() == "bullet"
    default_world.tell_default({"world": "bullet"}, [])
    default_world.tell_default({"world": "mujoco"}, [])
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("python", "platform", "machine", "wanted"),
    [
        ("3.11", "linux", "x86_64", True),
        ("3.12", "linux", "x86_64", False),
        ("3.13", "linux", "x86_64", False),
        ("3.11", "darwin", "arm64", False),
        ("3.11", "linux", "aarch64", False),
    ],
)
def test_pybullet_is_asked_for_only_where_it_has_a_wheel(python, platform, machine, wanted):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needs = {(r := Requirement(text)).name: r for text in project["dependencies"]}
    marker = needs["pybullet"].marker
    desk = {"python_version": python, "sys_platform": platform, "platform_machine": machine}
    assert marker is not None
    assert marker.evaluate(desk) is wanted
    assert all(need.marker is None for name, need in needs.items() if name != "pybullet")


def chosen(home: Path, *running: str) -> str:
    """The interpreter that the Makefile finds where those named run and all others refuse to."""
    search = re.search(r"^PYTHON \?= \$\(shell (.*?)\)$", MAKEFILE, re.MULTILINE | re.DOTALL)
    assert search
    for name in ("python3", "python3.11", "python3.12", "python3.13"):
        (home / name).write_text(f"#!/bin/sh\nexit {int(name not in running)}\n")
        (home / name).chmod(0o755)
    script = search[1].replace("$$", "$").replace("/usr/", f"{home}/none/").replace("\\\n", "")
    done = subprocess.run(["/bin/sh", "-c", script], capture_output=True, text=True, env={"PATH": str(home)})
    return done.stdout.strip().removeprefix(f"{home}/")


@pytest.mark.parametrize(
    ("running", "wanted"),
    [
        (["python3.13", "python3.12", "python3.11"], "python3.11"),
        (["python3.13", "python3.12"], "python3.12"),
        (["python3.13"], "python3.13"),
        (["python3.10"], ""),
    ],
)
def test_make_takes_the_first_python_that_runs_and_3_11_before_others(running, wanted, tmp_path):
    assert chosen(tmp_path, *running) == wanted


def test_make_run_installs_what_running_needs_and_make_test_the_rest(tmp_path):
    """As in a fresh clone, where nothing is installed yet."""
    for name in ("Makefile", "pyproject.toml", "requirements.lock"):
        (tmp_path / name).write_text((ROOT / name).read_text())
    asked = {
        target: re.findall(
            r'--editable "(.*?)"', subprocess.check_output(["make", "-n", target], text=True, cwd=tmp_path)
        )
        for target in ("run", "test")
    }
    assert asked == {"run": ["."], "test": [".[dev]"]}
