"""A command given inside a stranger's folder imports nothing from it."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from tests.experiment.test_resume import cut, same
from tests.experiment.test_resume import whole as whole_run
from tests.pages import ROOT

whole = whole_run
NAMES = ("hydra", "psutil", "numpy", "json", "typing", "deformpush_x", "yaml", "omegaconf", "sitecustomize")
TRAP = "open(__file__ + '.ran', 'w').close()\nraise SystemExit('imported')\n"


def trapped(folder: Path) -> Path:
    """Put modules into a folder that leave a mark when they are imported."""
    for name in NAMES:
        (folder / f"{name}.py").write_text(TRAP)
    return folder


def carry_out(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert [file.name for file in folder.rglob("*.ran")] == [], done.stderr
    return done


def test_resume_in_the_folder_itself_imports_none_of_its_modules(tmp_path, whole):
    folder = trapped(cut(whole, tmp_path / "run", 14))
    done = carry_out(folder, sys.executable, "-m", "deformpush", "resume", ".")
    assert done.returncode == 0, done.stderr
    same(folder, whole)


@pytest.mark.slow
def test_the_workers_of_a_sweep_import_none_either(tmp_path):
    folder = trapped(tmp_path)
    settings = ("world=toy", "robot=tool", "record=off", "max_pushes=10", "seed=1,2", "hydra.sweep.dir=many")
    command = (sys.executable, "-m", "deformpush", "-m", *settings, "hydra/launcher=joblib")
    done = carry_out(folder, *command)
    assert done.returncode == 0, done.stderr
    assert len(list((folder / "many").glob("*/summary.json"))) == 2


def test_the_command_of_an_installation_imports_none_either(tmp_path, whole):
    command = shutil.which("deformpush", path=sysconfig.get_path("scripts"))
    if command is None:
        pytest.skip("deformpush is not installed here")
    folder = trapped(cut(whole, tmp_path / "run", 14))
    assert carry_out(folder, command, "status", ".").returncode == 0
