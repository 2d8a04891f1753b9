"""The import rules of docs/architecture.md: which room may know which library and which other room."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "deformpush"
MODULES = {f.relative_to(PACKAGE).with_suffix("").as_posix(): f for f in sorted(PACKAGE.rglob("*.py"))}
MATHEMATICS = (
    "camera",
    "contour",
    "contour_strain",
    "task",
    "push",
    "seeding",
    "plane",
    "quasi_static",
    "gp/",
    "model/",
    "optimizer/",
)

ONLY_IN = {
    "hydra": ("launch", "config", "composition", "sweep/beginning", "sweep/launchers", "tuning/space"),
    "omegaconf": (
        *("launch", "config", "composition", "assemble", "execution", "replay"),
        *("sweep/job", "sweep/beginning"),
    ),
    "pydantic": ("hints",),
    "pybullet": ("sim/",),
    "pybullet_data": ("sim/",),
    "pybullet_utils": ("sim/",),
    "rerun": ("record/", "compare", "view"),
}
MATHEMATICS_MAY_USE = {
    *(
        "camera",
        "contour",
        "contour_strain",
        "errors",
        "task",
        "push",
        "plane",
        "quasi_static",
        "seeding",
        "gp",
        "model",
        "optimizer",
    )
}


def imported(file: Path) -> set[str]:
    """Names of the modules a file imports, anywhere in it; imports for type checkers only do not count."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    skipped = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    nodes = [node for node in ast.walk(tree) if id(node) not in skipped]
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    for node in nodes:
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file.name}: absolute imports only"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("module", MODULES)
def test_a_library_stays_in_its_rooms(module):
    libraries = {name.partition(".")[0] for name in imported(MODULES[module])}
    for library, rooms in ONLY_IN.items():
        assert library not in libraries or module.startswith(rooms), library


@pytest.mark.parametrize("module", [m for m in MODULES if m.startswith(MATHEMATICS)])
def test_the_mathematics_knows_no_other_room(module):
    """So that it serves a real robot cell as it stands."""
    rooms = {name.split(".")[1] for name in imported(MODULES[module]) if name.startswith("deformpush.")}
    assert rooms <= MATHEMATICS_MAY_USE


@pytest.mark.parametrize("module", [m for m in MODULES if m.startswith("gp/")])
def test_regression_knows_nothing_of_pushing(module):
    rooms = {name.split(".")[1] for name in imported(MODULES[module]) if name.startswith("deformpush.")}
    assert rooms <= {"gp", "errors"}


@pytest.mark.parametrize("module", [m for m in MODULES if m.startswith(("sim/", "contour", "push", "task"))])
def test_of_recording_the_cell_knows_only_the_record(module):
    names = {name for name in imported(MODULES[module]) if name.startswith("deformpush.record")}
    assert all(name.startswith("deformpush.push_record.") for name in names)


@pytest.mark.parametrize(
    "module", ["deformpush.loop", "deformpush.experiment.assemble", "deformpush.optimizer.abo"]
)
def test_heavy_libraries_wait_until_they_are_used(module):
    heavy = {"torch", "scipy", "pandas", "matplotlib", "rerun", "pybullet", "sklearn", "botorch", "optuna"}
    code = f"import sys, {module}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PACKAGE.parent
    )
    assert done.stdout == "[]\n"
