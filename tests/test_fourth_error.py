"""A fourth error term, added as docs/extending.md tells, is there wherever errors are, by one table alone.

The package is copied, and in the copy only task.py and one YAML file are edited.
"""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent

TERM = """\
    ErrorTerm(
        name="girth",
        symbol="e_girth",
        tex="$e_g$",
        unit="%",
        column="girth_change",
        scale=100.0,
        digits=2,
        colour=(204, 121, 167),
        measured=lambda seen, target: _girth(seen.contour) / _girth(target.outline) - 1.0,
        relative=lambda change, target: change,
        signed=True,
        weight="k_girth",
        stop="girth",
        stop_scale=1.0,
    ),
)
\"\"\"The errors (1)-(3)."""
GIRTH = '''\
def _girth(outline: Array) -> float:
    """Length of a closed line (m)."""
    return float(np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1).sum())


TERMS = ('''
EDITS = {
    "deformpush/task.py": [
        (')\n"""The errors (1)-(3).', TERM),
        ("TERMS = (", GIRTH),
        ("    k_c: ", "    k_girth: Annotated[float, Interval(gt=0)]\n\\g<0>"),
        ("    on_damage: bool = False\n", "    girth: Annotated[float, Interval(gt=0)] = 0.2\n\\g<0>"),
    ],
    "conf/task/default.yaml": [("  k_gamma: 1.0\n", "\\g<0>  k_girth: 0.5\nstop:\n  girth: 0.2\n")],
}


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A run of the copy, recorded, with its figures; what it said stands beside it."""
    home = tmp_path_factory.mktemp("fourth")
    for name in ("deformpush", "conf"):
        shutil.copytree(ROOT / name, home / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name, edits in EDITS.items():
        text = (home / name).read_text(encoding="utf-8")
        for old, new in edits:
            text, count = re.subn(re.escape(old), new.replace("\\", "\\\\").replace("\\\\g", "\\g"), text)
            assert count == 1, f"{name}: {old!r}"
        (home / name).write_text(text, encoding="utf-8")
    settings = ["world=toy", "robot=tool", "record=light", "max_pushes=12", "hydra.run.dir=run"]
    done = deformpush(home, *settings)
    assert (done.returncode, done.stderr) == (0, "")
    (home / "said.txt").write_text(done.stdout)
    return home


def deformpush(home: Path, *argv: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(home)}
    line = [sys.executable, "-m", "deformpush", *argv]
    return subprocess.run(line, capture_output=True, text=True, cwd=home, env=environment, check=False)


def rows(made: Path) -> list[dict[str, str]]:
    with (made / "run" / "pushes.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_it_is_a_column_of_the_table_and_part_of_the_total(made):
    table = rows(made)
    names = list(table[0])
    assert names[names.index("e_gamma") + 1] == "e_girth"
    assert "girth_change" in names
    for row in table:
        parts = 3 * float(row["e_c"]) + 3 * abs(float(row["e_theta"])) + float(row["e_gamma"])
        assert float(row["e_T"]) == pytest.approx(parts + 0.5 * abs(float(row["e_girth"])), abs=1e-12)
    assert len({row["e_girth"] for row in table}) > 1


def test_it_is_in_the_summary_and_on_the_terminal(made):
    end, last = json.loads((made / "run" / "summary.json").read_text()), rows(made)[-1]
    assert end["e_girth"] == float(last["e_girth"])
    assert end["girth_change"] == float(last["girth_change"])
    shown = abs(100 * end["girth_change"])
    errors = next(line for line in (made / "said.txt").read_text().splitlines() if line.startswith("errors:"))
    assert errors.endswith(f", girth {shown:.2f} %")


def test_it_is_recorded(made):
    from rerun.chunk import RrdReader

    chunks = RrdReader(str(made / "run" / "recording.rrd")).stream().to_chunks()
    assert "/errors/girth" in {chunk.entity_path for chunk in chunks}


def test_it_is_kept_with_the_contours(made):
    kept = np.load(made / "run" / "contours.npz")
    assert kept["stops"].shape == kept["error_stops"].shape == (4,)
    assert kept["stops"][3] == 0.2


def test_it_is_in_the_figure(made):
    import cv2

    figure = cv2.imread(str(made / "run" / "figures" / "run.png"))[:, :, ::-1].reshape(-1, 3)
    assert np.all(np.abs(figure.astype(int) - (204, 121, 167)) < 8, axis=1).sum() > 50, "a line in its colour"


def test_runs_with_it_are_compared_reported_and_taken_up(made):
    done = deformpush(made, "compare", "run", "--out", "compared")
    assert (done.returncode, done.stderr) == (0, "")
    assert "girth (%)" in done.stdout.splitlines()[0]
    assert "e_girth" in (made / "compared" / "compare.csv").read_text().splitlines()[0]
    done = deformpush(made, "report", "run", "--out", "page.html")
    assert (done.returncode, done.stderr) == (0, "")
    assert "girth" in (made / "page.html").read_text()
    done = deformpush(made, "replay", "run")
    assert done.stdout.startswith("identical: 12 pushes"), done.stderr


def test_runs_without_it_can_still_be_compared(made):
    old = ROOT / "tests" / "data" / "run_0_1"
    done = deformpush(made, "compare", "run", str(old), "--out", "both")
    assert done.returncode == 0, done.stderr
    table = [line.split(",") for line in (made / "both" / "compare.csv").read_text().splitlines()]
    assert len(table) == 3


def test_the_run_stops_only_where_it_is_small_too(made):
    """Its stop value is a setting like those of the others."""
    argv = ["world=toy", "robot=tool", "record=off", "optimizer=greedy"]
    done = deformpush(made, *argv, "hydra.run.dir=lax")
    assert done.stdout.startswith("reached: reached the goal after 7 pushes"), done.stderr
    done = deformpush(made, *argv, "task.stop.girth=1e-9", "max_pushes=7", "hydra.run.dir=strict")
    assert done.stdout.startswith("budget: did not reach the goal after 7 pushes"), done.stderr
