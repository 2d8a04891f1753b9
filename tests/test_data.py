"""docs/data.md lists what a run's folder holds: nothing that is not there, and all that is."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from tests import pages
from tests.data_page import KINDS, PAGE, SECTIONS, Made, Shapes, agree, holds, is_a, rows
from tests.pages import ROOT
from tests.viewer.recording import Contents

TOY = ("world=toy", "robot=tool")
MOTION = (*TOY, "optimizer=abo_motion", "record=full", "max_pushes=3")
LIGHT = (*TOY, "record=light", "max_pushes=3", "optimizer.S0=2")
SAFE = (*TOY, "optimizer=abo_motion", "object=fish_fillet", "acquisition=safe_lcb", "acq.signal=contour")
TABLES_OF_FILES = ("Files", "Files of `regret`")
UNITS = {"-", "m", "mm", "rad", "deg", "s", "m/s", "px", "N"}


def command(*argv: str, folder: Path) -> str:
    """Carry out a command in a folder; what it printed."""
    line = [sys.executable, "-m", "deformpush", *argv]
    surroundings = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(line, capture_output=True, text=True, cwd=folder, env=surroundings, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("data")


@pytest.fixture(scope="module")
def motion(home) -> Made:
    """With forecasts, and with all that can be recorded."""
    command(*MOTION, "hydra.run.dir=motion", folder=home)
    return Made(home / "motion")


@pytest.fixture(scope="module")
def light(home) -> Made:
    """The paper's model, recorded lightly."""
    command(*LIGHT, "hydra.run.dir=light", folder=home)
    return Made(home / "light")


@pytest.fixture(scope="module")
def safe(home) -> Made:
    """With a process on the strain."""
    command(*SAFE, "record=off", "max_pushes=1", "hydra.run.dir=safe", folder=home)
    return Made(home / "safe")


@pytest.fixture(scope="module")
def resumed(home) -> Made:
    """Killed after two pushes, then taken up again."""
    command(*LIGHT, "record=off", "hydra.run.dir=resumed", folder=home)
    folder = home / "resumed"
    (folder / "summary.json").unlink()
    lines = (folder / "pushes.csv").read_bytes().splitlines(keepends=True)
    (folder / "pushes.csv").write_bytes(b"".join(lines[:-1]))
    command("resume", "resumed", folder=home)
    return Made(folder)


@pytest.fixture(scope="module")
def sweep(home) -> Path:
    """Two runs."""
    quick = ("record=off", "optimizer=random", "max_pushes=2", "seed=0,1")
    command("-m", *TOY, *quick, "hydra.sweep.dir=sweep", folder=home)
    return home / "sweep"


@pytest.fixture(params=["motion", "light", "safe", "resumed"])
def made(request) -> Made:
    """Each of the runs."""
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module")
def regretted(motion, home) -> Made:
    """With the files of the verb `regret`."""
    shutil.copytree(motion.folder, home / "regretted")
    command("regret", "regretted", "--pushes", "2", folder=home)
    return Made(home / "regretted")


def files(folder: Path) -> set[str]:
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}


def test_every_file_has_a_section_and_every_section_a_file():
    named = {row["name"] for heading in (*TABLES_OF_FILES, "The folder of a sweep") for row in rows(heading)}
    told = named - {".lock", "multirun.yaml"} | {"states.bin"}
    assert {name.strip("`") for name in SECTIONS if name[0] == "`"} == told


@pytest.mark.parametrize("heading", [name for name, text in SECTIONS.items() if "| unit |" in text])
def test_every_row_has_a_unit_and_a_meaning(heading):
    before = None
    for row in rows(heading):
        assert set(row["unit"].split(", ")) <= UNITS, row
        # An empty cell says: as the row above.
        assert row["what"] or before, row
        before = row["what"] or before


def test_the_files(made):
    agree([r["name"] for r in rows("Files") if holds(r["when"], made.config)], files(made.folder), False)


def test_config_yaml(made):
    told = rows("`config.yaml`")
    agree([row["name"] for row in told], made.config, ordered=False)
    assert [row for row in told if not is_a(made.config[row["name"]], row["type"])] == []
    for row in told:
        for folder in re.findall(r"`(conf/\w+)/`", row["what"]):
            assert (ROOT / folder).is_dir(), row


def test_provenance_json(made):
    found = json.loads((made.folder / "provenance.json").read_text(encoding="utf-8"))
    for part in found.get("resumed", []):
        assert set(part) == set(found) - {"resumed"} | {"after"}
    flat = found | {f"git.{name}": value for name, value in (found["git"] or {}).items()}
    flat |= {f"kernels.{name}": value for name, value in found["kernels"].items()}
    told = {row["name"]: row for row in rows("`provenance.json`")}
    again = made.summary["resumed"] is not None
    optional = {*([] if again else ["resumed"]), *({"kernels.torch"} - set(flat))}
    expected = [name for name in told if name not in optional]
    agree([n for n in expected if found["git"] or not n.startswith("git.")], flat, ordered=False)
    assert [name for name, value in flat.items() if not is_a(value, told[name]["type"])] == []


@pytest.mark.parametrize("name", ["pushes.csv", "forecasts.csv"])
def test_tables(name, made):
    if name not in files(made.folder):
        return
    told = rows(f"`{name}`")
    header, body = made.table(name)
    agree([row["name"] for row in told], header)
    assert len(body) == made.summary["pushes"] + (name == "pushes.csv")
    for row, cells in zip(told, zip(*body, strict=True), strict=True):
        for cell in filter(None, cells):
            assert re.fullmatch(KINDS[row["type"]], cell), (row, cell)


def test_the_files_of_regret(motion, regretted):
    told = [row["name"] for row in rows("Files of `regret`")]
    agree(told, files(regretted.folder) - files(motion.folder), ordered=False)


@pytest.mark.parametrize(("name", "a_push"), [("regret.csv", 1), ("regret_trials.csv", 2)])
def test_the_tables_of_regret(name, a_push, regretted):
    told = rows(f"`{name}`")
    header, body = regretted.table(name)
    agree([row["name"] for row in told], header)
    assert len(body) == a_push * regretted.summary["pushes"]
    for row, cells in zip(told, zip(*body, strict=True), strict=True):
        for cell in filter(None, cells):
            assert re.fullmatch(KINDS[row["type"]], cell), (row, cell)


def test_summary_json(made):
    told = {row["name"]: row["type"] for row in rows("`summary.json`")}
    agree(told, made.summary)
    assert [name for name, kind in told.items() if not is_a(made.summary[name], kind)] == []


def check_arrays(told: list[dict[str, str]], found: Mapping[str, np.ndarray], run: Made) -> None:
    """Names, types and shapes of arrays are as a table has them."""
    agree([row["name"] for row in told], found, ordered=False)
    shapes = Shapes(run)
    for row in told:
        array = found[row["name"]]
        assert str(array.dtype) == row["type"], row
        assert shapes.fits(row["shape"], array.shape), (row, array.shape, shapes.known)


@pytest.mark.parametrize("name", ["contours.npz", "views.npz"])
def test_arrays(name, made):
    with np.load(made.folder / name, allow_pickle=False) as file:
        check_arrays(rows(f"`{name}`"), dict(file), made)


def test_checkpoint_npz(made):
    with np.load(made.folder / "checkpoint.npz", allow_pickle=False) as file:
        found = dict(file)
    facts = json.loads(str(found.pop("json")))
    told = [row for row in rows("`checkpoint.npz`") if holds(row["when"], made.config)]
    check_arrays([row for row in told if not row["type"].startswith("json")], found, made)
    numbers = {row["name"]: row["type"] for row in told if row["type"].startswith("json")}
    agree(numbers, facts, ordered=False)
    assert [n for n, kind in numbers.items() if not is_a(facts[n], kind.removeprefix("json "))] == []


def test_the_pictures_and_poses_are_where_it_says(motion):
    """Frames and units: poses, paths and goal in the table frame, in metres."""
    _, body = motion.table("pushes.csv")
    with np.load(motion.folder / "contours.npz") as file:
        poses = dict(file)
    with np.load(motion.folder / "views.npz") as file:
        ends, data = file["ends"], file["data"].tobytes()
    assert [data[a : a + 2] for a in (0, *ends[:-1])] == [b"\xff\xd8"] * len(ends)
    assert np.isnan(poses["starts"][0]).all()
    assert np.isnan(poses["ends"][0]).all()
    away = np.linalg.norm(poses["centroids"] - poses["goal_c"], axis=1)
    np.testing.assert_allclose(away, [float(row[9]) for row in body], rtol=1e-12)
    _, forecasts = motion.table("forecasts.csv")
    came = np.array([[row[3], row[6], row[9]] for row in forecasts], float)
    np.testing.assert_array_equal(came, np.column_stack([poses["centroids"], poses["thetas"]])[1:])


def test_the_recording(motion, light):
    for run in (motion, light):
        told = [row["name"] for row in rows("`recording.rrd`") if holds(row["when"], run.config)]
        entities = Contents(run.folder / "recording.rrd").entities
        agree(told, {name for name in entities if not name.startswith("/__")}, ordered=False)


def test_the_folder_of_a_sweep(sweep):
    told = [row["name"] for row in rows("The folder of a sweep")]
    agree(told, [file.name for file in sweep.iterdir() if file.is_file()], ordered=False)


def test_sweep_json(sweep):
    found = json.loads((sweep / "sweep.json").read_text(encoding="utf-8"))
    told = {row["name"]: row["type"] for row in rows("`sweep.json`")}
    for job in found["jobs"]:
        flat = found | {f"jobs.{name}": value for name, value in job.items()}
        agree(told, flat, ordered=False)
        assert [name for name, kind in told.items() if not is_a(flat[name], kind)] == []


def test_sweep_csv(sweep):
    told = rows("`sweep.csv`")
    with (sweep / "sweep.csv").open(encoding="utf-8", newline="") as file:
        header, *body = list(csv.reader(file))
    given = ["world", "robot", "record", "optimizer", "max_pushes", "seed"]
    names = [row["name"] for row in told]
    at = names.index("reason") + 1
    agree([*names[:at], *given, *(name for name in names[at:] if name not in given)], header)
    assert len(body) == 2
    for row in told:
        for cell in (cells[header.index(row["name"])] for cells in body):
            kind, _, null = row["type"].partition(" or ")
            assert (null and not cell) or re.fullmatch(KINDS[kind], cell), (row, cell)


def test_the_example_reads_a_run(light, tmp_path):
    (block,) = pages.blocks(PAGE, "python")
    shutil.copytree(light.folder, tmp_path / "runs" / "mine")
    line = [sys.executable, "-c", block]
    surroundings = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(line, capture_output=True, text=True, cwd=tmp_path, env=surroundings, check=True)
    assert "(4, 128, 2) budget" in done.stdout
