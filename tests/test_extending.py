"""Every example of docs/extending.md runs as shown, outside the checkout, and makes a difference."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from deformpush.config.groups import conf_dir
from deformpush.mechanics.geometry import signed_area
from deformpush.record import checkpoint, table
from tests.pages import ROOT, blocks, named_files, page, sections, write

PAGE = page("docs/extending.md")
SECTIONS = sections(PAGE)
QUICK = ("robot=tool", "record=off", "max_pushes=9")
"""Added to every run that the page shows."""
MODEL = ("world=toy", "optimizer.S0=4")

TOLD = 1e-5
"""What a model says of a push is written with seven digits."""


def commands(section: str) -> list[str]:
    """The lines of the shell that a section shows."""
    return [line for block in blocks(SECTIONS[section], "sh") for line in block.splitlines()]


def files(section: str) -> dict[str, str]:
    """The files that a section shows, by name."""
    return named_files(SECTIONS[section], "python", "yaml", "diff")


def carry_out(
    line: str, folder: Path, *settings: str, package: Path = ROOT
) -> subprocess.CompletedProcess[str]:
    """Carry out a `deformpush` command in a folder."""
    first, *rest = shlex.split(line)
    assert first == "deformpush"
    environment = {"PATH": os.environ["PATH"], "HOME": str(folder), "PYTHONPATH": str(package)}
    command = [sys.executable, "-m", "deformpush", *rest, *settings]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)


def shell(line: str, folder: Path, *settings: str, package: Path = ROOT) -> str:
    """Carry out a command that must end well; what it printed."""
    done = carry_out(line, folder, *settings, package=package)
    assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
    return done.stdout


def refused(line: str, folder: Path, *settings: str) -> str:
    """Carry out a command that must be refused; the line that says why."""
    done = carry_out(line, folder, *settings)
    assert done.returncode == 2, done.stdout
    return done.stderr


class Run:
    """A run of the page's n-th command."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.config: dict[str, Any] = yaml.safe_load((folder / "config.yaml").read_text(encoding="utf-8"))
        self.pushes: pd.DataFrame = table.read(folder / "pushes.csv")

    @property
    def chosen(self) -> pd.DataFrame:
        """The pushes after the initial design."""
        return self.pushes[self.pushes["phase"].isin(["explore", "exploit"])]


Maker = Callable[..., Run]


@pytest.fixture
def make(tmp_path) -> Maker:
    """Put the files of a section into an empty folder; make the run of its n-th command there."""
    assert not tmp_path.is_relative_to(ROOT)

    def maker(section: str, n: int, *settings: str) -> Run:
        write(files(section), tmp_path)
        shell(commands(section)[n], tmp_path, *QUICK, *settings, f"hydra.run.dir=run-{n}")
        return Run(tmp_path / f"run-{n}")

    return maker


@pytest.fixture(scope="module")
def usual(tmp_path_factory) -> Run:
    """A run with nothing of one's own."""
    folder = tmp_path_factory.mktemp("usual")
    shell("deformpush", folder, *QUICK, *MODEL, "hydra.run.dir=run")
    return Run(folder / "run")


def test_the_page_has_a_section_for_every_row_of_its_table():
    links = re.findall(r"^\| \[(.*?)\]\(#(.*?)\)", PAGE, re.MULTILINE)
    assert [name.capitalize() for name, _ in links] == list(SECTIONS)
    assert [link for _, link in links] == [name.lower().replace(" ", "-") for name in SECTIONS]


def test_every_file_it_tells_to_read_exists():
    named = set(re.findall(r"`((?:deformpush|conf|tests)/[\w/]+\.(?:py|yaml))`", PAGE))
    assert len(named) >= 9
    assert [name for name in named if not (ROOT / name).is_file()] == []


def test_every_block_names_its_file():
    for section in SECTIONS:
        for name in files(section):
            assert re.fullmatch(r"my_conf/[\w/]+\.(py|yaml)|\w+\.diff", name), name


def test_an_object(make):
    run = make("An object", 0, *MODEL)
    shown = yaml.safe_load(files("An object")["my_conf/object/wedge.yaml"])
    assert run.config["object"]["outline"] == shown["outline"]
    assert run.config["object"]["material"]["mass"] == 0.15
    assert run.config["object"]["rgb"] == yaml.safe_load((conf_dir() / "object/rect.yaml").read_text())["rgb"]
    assert run.pushes["d"].between(0.005, 0.025)[1:].all()
    with np.load(run.folder / "contours.npz") as arrays:
        x, y = arrays["contours"][0].T
    assert np.ptp(x) == pytest.approx(0.17, abs=0.004)
    assert np.ptp(y) == pytest.approx(0.12, abs=0.004)


@pytest.mark.parametrize(("n", "name"), [(0, "space_alpha"), (1, "time_alpha")])
def test_a_kernel_learns_its_number(n, name, make, usual):
    run = make("A kernel", n, *MODEL)
    field = name.partition("_")[0]
    assert run.config["kernel"][field]["_target_"] == "rational_quadratic.RationalQuadratic"
    theta = checkpoint.read(run.folder / "checkpoint.npz").state["theta"]
    assert theta.shape == (6,)
    assert abs(np.exp(theta[5]) - run.config["kernel"][field]["alpha"]) > 1e-6
    first = len(usual.pushes) - len(usual.chosen)
    assert run.pushes["kappa"][1:first].tolist() == usual.pushes["kappa"][1:first].tolist()
    assert run.chosen["xi_std"].iloc[0] != usual.chosen["xi_std"].iloc[0]


def test_an_acquisition(make):
    run = make("An acquisition", 0, *MODEL)
    assert run.config["acq"] == {"_target_": "entropic.Entropic", "b": 4.0}
    chosen = run.chosen
    assert len(chosen) == 5
    np.testing.assert_allclose(chosen["acq"], chosen["xi_mean"] - 2.0 * chosen["xi_std"] ** 2, rtol=TOLD)


def test_an_acquisition_without_its_package_line_is_refused(make, tmp_path):
    make("An acquisition", 0, *MODEL)
    file = tmp_path / "my_conf" / "acquisition" / "entropic.yaml"
    file.write_text(file.read_text(encoding="utf-8").replace("# @package acq\n", ""), encoding="utf-8")
    line = "deformpush --config-dir my_conf acquisition=entropic"
    said = refused(line, tmp_path, *QUICK, *MODEL)
    assert said.startswith(
        "acquisition: unknown; this group's settings stand under acq: begin its file with "
    )
    assert "`# @package acq`" in said


def test_an_acquisition_may_be_kept_to_gentle_pushes(make, tmp_path):
    make("An acquisition", 0, *MODEL)
    preset = (conf_dir() / "acquisition" / "safe_ei.yaml").read_text(encoding="utf-8")
    mine, replaced = re.subn(
        r"(inner:\n  _target_: ).*\n  margin: .*", r"\1entropic.Entropic\n  b: 3.0", preset
    )
    assert replaced == 1
    (tmp_path / "my_conf" / "acquisition" / "gentle.yaml").write_text(mine, encoding="utf-8")
    line = "deformpush --config-dir my_conf acquisition=gentle object=fish_fillet acq.signal=contour"
    shell(line, tmp_path, *QUICK, "world=toy", "optimizer.S0=1", "max_pushes=2", "hydra.run.dir=gentle")
    chosen = Run(tmp_path / "gentle").chosen
    np.testing.assert_allclose(chosen["acq"], chosen["xi_mean"] - 1.5 * chosen["xi_std"] ** 2, rtol=TOLD)


def test_a_world(make, tmp_path):
    run = make("A world", 1, "optimizer.S0=4")
    assert "all gates hold" in shell(commands("A world")[0], tmp_path)
    assert run.config["world"]["_target_"] == "glide.Glide"
    assert (run.config["world"]["grip"], run.config["options"]["world"]) == (0.8, "glide")
    with np.load(run.folder / "contours.npz") as arrays:
        moved = np.linalg.norm(np.diff(arrays["centroids"], axis=0), axis=1)
        turned = np.abs(arrays["thetas"] - arrays["thetas"][0])
    np.testing.assert_allclose(moved, 0.8 * run.pushes["d"][1:], atol=1e-3)
    assert turned.max() < 0.01


def test_a_world_may_be_the_option_itself(make, tmp_path):
    """A class of a real cell has no `build`; its fields are the settings."""
    make("A world", 1, "optimizer.S0=4")
    (tmp_path / "my_conf" / "cell_of_mine.py").write_text(
        "from dataclasses import dataclass\n"
        "from deformpush.cell.camera import Camera\n"
        "from deformpush.cell.object import SoftObject\n"
        "from glide import Glide, GlideWorld\n"
        "@dataclass\n"
        "class CellOfMine(GlideWorld):\n"
        "    port: str\n"
        "    sheet: SoftObject\n"
        "    camera: Camera\n"
        "    def __post_init__(self) -> None:\n"
        "        super().__init__(Glide(), self.sheet, self.camera)\n"
    )
    (tmp_path / "my_conf" / "world" / "cell_of_mine.yaml").write_text(
        "_target_: cell_of_mine.CellOfMine\nport: /dev/null\nsheet: ${object}\ncamera: ${camera}\n"
    )
    line = "deformpush --config-dir my_conf world=cell_of_mine"
    shell(line, tmp_path, *QUICK, "optimizer.S0=4", "hydra.run.dir=mine")
    assert Run(tmp_path / "mine").config["world"]["port"] == "/dev/null"
    assert "all gates hold" in shell("deformpush doctor --config-dir my_conf world=cell_of_mine", tmp_path)


def test_a_method(make, tmp_path):
    run = make("A method", 0, "world=toy", "optimizer.step=0.02")
    assert run.config["optimizer"]["_target_"] == "hill_climb.HillClimb"
    pushes = run.pushes[1:]
    assert list(pushes["phase"]) == ["initial"] * 5 + ["explore"] * 4
    U = pushes[["kappa", "d"]].to_numpy()
    width = np.array([1.0, 0.02])
    for k in range(5, 9):
        best = U[:k][np.argmin(pushes["xi"][:k])]
        assert (np.abs(U[k] - best) <= 5 * 0.02 * width).all()
        assert (U[k] != best).any()
    assert "identical" in shell(f"deformpush replay {run.folder} --config-dir my_conf", tmp_path)
    line = "deformpush --config-dir my_conf optimizer=hill_climb kernel=rbf"
    told = refused(line, tmp_path, *QUICK, "world=toy")
    assert told.startswith("kernel=rbf: optimizer=hill_climb does not use it")


def test_an_error_term(tmp_path):
    for part in ("deformpush", "conf"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "e_area.diff").write_text(files("An error term")["e_area.diff"], encoding="utf-8")
    patch, line, test = (shlex.split(text) for text in commands("An error term"))
    surroundings = {
        **os.environ,
        "PYTHONPATH": str(tmp_path),
        "GIT_CEILING_DIRECTORIES": str(tmp_path.parent),
    }
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    subprocess.run(patch, cwd=tmp_path, env=surroundings, check=True)
    tested = [sys.executable, *test[1:], "-p", "no:cacheprovider", "-q"]
    done = subprocess.run(tested, cwd=tmp_path, env=surroundings, capture_output=True, text=True, check=False)
    assert "2 passed" in done.stdout, done.stdout

    told = shell(
        shlex.join(line),
        tmp_path,
        *QUICK,
        *MODEL,
        "hydra.run.dir=run",
        "record.figures=true",
        package=tmp_path,
    )
    rows = pd.read_csv(tmp_path / "run" / "pushes.csv")
    summary = json.loads((tmp_path / "run" / "summary.json").read_text(encoding="utf-8"))
    config = yaml.safe_load((tmp_path / "run" / "config.yaml").read_text(encoding="utf-8"))
    weights = config["task"]["weights"]
    assert (weights["k_area"], config["task"]["stop"]["e_area"]) == (0.5, 0.1)
    assert list(rows.columns[5:10]) == ["e_c", "e_theta", "e_gamma", "e_area", "e_T"]
    with np.load(tmp_path / "run" / "contours.npz") as arrays:
        goal = signed_area(arrays["goal_outline"])
        areas = np.array([signed_area(contour) for contour in arrays["contours"]])
        assert arrays["stops"].shape == (4,)
    np.testing.assert_allclose(rows["e_area"], np.abs(areas / goal - 1), atol=1e-12)
    assert rows["e_area"].nunique() > 5
    terms = {"k_c": "e_c", "k_theta": "e_theta", "k_gamma": "e_gamma", "k_area": "e_area"}
    total = sum(weights[name] * rows[column].abs() for name, column in terms.items())
    np.testing.assert_allclose(rows["e_T"], total, rtol=1e-12)
    assert summary["e_area"] == rows["e_area"].iloc[-1]
    assert f"area {100 * summary['e_area']:.1f} %" in told
    assert (tmp_path / "run" / "figures" / "run.png").stat().st_size > 10_000
