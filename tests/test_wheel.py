"""The built wheel holds everything and runs from an empty folder, away from the checkout."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(ROOT))
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("installed")
    pip("install", "--no-deps", "--target", str(folder), str(wheel))
    return folder


def pip(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "pip", "--quiet", *arguments], check=True)


def run(installed: Path, folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    folder.mkdir()
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)


def test_the_wheel_holds_package_and_configuration_and_nothing_else(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    files = [
        *ROOT.glob("deformpush/**/*.py"),
        *ROOT.glob("conf/**/*.yaml"),
        *ROOT.glob("deformpush/study/page.*s"),
        ROOT / "deformpush" / "py.typed",
    ]
    expected = {f.relative_to(ROOT).as_posix() for f in files}
    expected = {f"deformpush/{name}" if name.startswith("conf/") else name for name in expected}
    assert {name for name in names if ".dist-info/" not in name} == expected


def test_an_installed_package_reads_its_own_configuration(installed, tmp_path):
    command = (sys.executable, "-m", "deformpush", "--info", "searchpath")
    done = run(installed, tmp_path / "empty", *command)
    assert done.returncode == 0, done.stderr
    assert f"file://{installed}/deformpush/conf" in done.stdout


def test_the_console_script_makes_a_run_in_any_folder(installed, tmp_path):
    script = installed / "bin" / "deformpush"
    toy = ("world=toy", "robot=tool", "record=off", "max_pushes=11")
    done = run(installed, tmp_path / "empty", sys.executable, str(script), *toy, "hydra.run.dir=here")
    assert done.returncode == 0, done.stderr
    written = {file.name for file in (tmp_path / "empty" / "here").iterdir()}
    assert {"config.yaml", "provenance.json", "pushes.csv", "summary.json"} <= written
