"""The package keeps the rules of the house, and each rule notices a package that breaks it."""

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.house_rules import (
    MATHEMATICS,
    MAY_IMPORT,
    PACKAGE,
    ROOT,
    Modules,
    circle,
    engine_outside_worlds,
    error_spelt_out,
    file_too_long,
    import_of_another_room,
    library_outside_its_rooms,
    library_without_a_room,
    mathematics_that_sees,
    modules,
    recorder_in_the_loop,
    room_without_a_row,
    too_many_rooms_or_floors,
    untyped_contract,
    verb_outside_cli,
)

Rule = Callable[[Modules], Iterator[str]]
RULES: dict[Rule, dict[str, str]] = {
    library_outside_its_rooms: {
        "study/new.py": "def draw():\n    import rerun as rr\n",
        "checks/new.py": "from pybullet import connect\n",
        "worlds/bullets.py": "import pybullet\n",
        "config_more.py": "from hydra import compose\n",
        "gp/new.py": "from deformpush.extras import library\nlibrary('optuna')\n",
        "study/verb.py": "import argparse\n",
    },
    library_without_a_room: {
        "gp/new.py": "import sklearn\n",
        "worlds/new.py": "import mujoco\n",
        "cell/new.py": "from .camera import Camera\n",
    },
    import_of_another_room: {
        "gp/new.py": "from deformpush.task import Task\n",
        "cell/new.py": "import typing\nif typing.TYPE_CHECKING:\n    from deformpush import loop\n",
        "record/new.py": "def f():\n    from deformpush.viewer import stream\n",
        "task_more.py": "from deformpush.cell import camera\n",
        "study/new.py": "from deformpush import World\n",
    },
    room_without_a_row: {"new.py": "", "cellar/new.py": ""},
    recorder_in_the_loop: {
        "loop.py": "def f():\n    from deformpush.record.table import Table\n",
    },
    verb_outside_cli: {"study/new.py": "def main(argv):\n    return 0\n"},
    engine_outside_worlds: {"cli/new.py": "from deformpush.worlds.toy import Toy\n"},
    mathematics_that_sees: {
        "optimizer/new.py": "from deformpush.cell.perception import Perception\n",
        "mechanics/new.py": "import cv2\n",
        "model/new.py": "from deformpush.cell.camera import Camera\n",
    },
    circle: {"cell/new.py": "import deformpush.viewer.stream\n"},
    too_many_rooms_or_floors: {
        "__main__.py": "from deformpush import one\n",
        "one.py": "from deformpush import two\n",
        "two.py": "from deformpush.cli import usage\n",
    },
    file_too_long: {"gp/new.py": "#\n" * 301, "loop.py": "#\n" * 151},
    error_spelt_out: {f"study/new{n}.py": "# e_gamma\n" for n in range(6)},
    untyped_contract: {
        "optimizer/new.py": "from typing import Any\ndef ask(state: Any | None): ...\n",
        "viewer/new.py": "from typing import Any\ndef scenery() -> Any: ...\n",
        "cell/new.py": "import typing\nclass A:\n    world: typing.Any\n",
    },
}
"""By rule: files that break it, each in its own way, but for those which only together do."""
TOGETHER = (too_many_rooms_or_floors, error_spelt_out)
CASES = [
    (rule, files)
    for rule, broken in RULES.items()
    for files in ([broken] if rule in TOGETHER else [{name: text} for name, text in broken.items()])
]


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_the_package_keeps_to(rule):
    assert list(rule(modules(PACKAGE))) == []


@pytest.mark.parametrize(("rule", "files"), CASES, ids=[f"{r.__name__}-{min(f)}" for r, f in CASES])
def test_a_package_that_breaks_it_is_noticed(rule, files):
    found = modules(PACKAGE)
    for name, text in files.items():
        path = Path(name).with_suffix("").parts
        found[path] = found.get(path, "") + text
    assert list(rule(found))


def test_the_table_of_the_architecture_is_this_one():
    """In its order no room knows one that stands below it."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ((?:`[a-z_]+(?:/|\.py)`(?:, )?)+) \|", text, re.MULTILINE)
    order = [name for row in rows for name in re.findall(r"`([a-z_]+)", row)]
    assert set(order) == set(MAY_IMPORT) - {"__init__", "__main__"}
    for n, room in enumerate(order):
        assert set(MAY_IMPORT[room].split()) <= set(order[:n]), room


def loaded_by(*names: str) -> set[str]:
    """Modules that a fresh process has after importing these."""
    code = f"import sys, {', '.join(names)}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PACKAGE.parent
    )
    return set(done.stdout.split())


HEAVY = {"torch", "scipy", "pandas", "matplotlib", "rerun", "pybullet", "sklearn", "botorch", "optuna"}


@pytest.mark.parametrize(
    "module", ["deformpush.loop", "deformpush.experiment.assemble", "deformpush.optimizer.abo"]
)
def test_heavy_libraries_wait_until_they_are_used(module):
    assert not loaded_by(module) & HEAVY


def test_the_mathematics_loads_no_eye_no_engine_and_no_configuration():
    """Nor does anything that it imports: `safe_lcb` needs no OpenCV."""
    everything = [
        ".".join(("deformpush", *path)).removesuffix(".__init__")
        for path in modules(PACKAGE)
        if path[0] in MATHEMATICS
    ]
    assert {"deformpush.optimizer.safe", "deformpush.model.motion"} <= set(everything)
    found = loaded_by(*everything)
    foreign = {"cv2", "pybullet", "hydra", "omegaconf", "rerun", "pydantic", "yaml"}
    assert not found & (foreign | HEAVY - {"scipy"})
    rooms = {name.split(".")[1] for name in found if name.startswith("deformpush.")}
    assert rooms <= {*MATHEMATICS, "cell", "task", "state", "errors", "extras"}
    assert not found & {"deformpush.cell.perception", "deformpush.cell.silhouette", "deformpush.cell.cell"}


def test_the_loop_loads_no_recorder():
    rooms = {name.split(".")[1] for name in loaded_by("deformpush.loop") if name.startswith("deformpush.")}
    assert not rooms & {"record", "viewer", "study", "experiment", "config", "cli", "worlds"}
