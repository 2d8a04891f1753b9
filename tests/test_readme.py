"""What the README tells a newcomer to type works as printed."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def own_files(tmp_path) -> Path:
    """The files that the README shows, each named by its first line."""
    for block in re.findall(r"```(?:yaml|python)\n# (my_conf/\S+)\n(.*?)```", README, re.DOTALL):
        file = tmp_path / block[0]
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(block[1], encoding="utf-8")
    return tmp_path


COMMANDS = re.findall(r"^deformpush (--config-dir .*)$", README, re.MULTILINE)


@pytest.mark.parametrize("command", COMMANDS)
def test_own_objects_and_methods_run_as_shown(command, own_files):
    quick = ["world=toy", "robot=tool", "record=off", "max_pushes=11", "hydra.run.dir=here"]
    line = [sys.executable, "-m", "deformpush", *command.split(), *quick]
    environment = {"PYTHONPATH": str(ROOT), "PATH": ""}
    done = subprocess.run(line, capture_output=True, text=True, cwd=own_files, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    config = (own_files / "here" / "config.yaml").read_text(encoding="utf-8")
    assert "youngs_modulus: 30000.0" in config or "inset: 0.2" in config


def test_the_readme_shows_both_an_object_and_a_method():
    assert len(COMMANDS) == 2


def test_every_make_target_it_names_exists():
    rules = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"make ([a-z-]+)(?=[ `]|$)", README, re.MULTILINE)) - {"run"} <= set(rules)
