"""No file of gp/ knows itself through others."""

import ast
from pathlib import Path

import deformpush.gp

FOLDER = Path(deformpush.gp.__file__).parent


def imported(file: Path) -> set[str]:
    names = {
        node.module or ""
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.ImportFrom)
    }
    return {name.removeprefix("deformpush.gp.") for name in names if name.startswith("deformpush.gp.")}


def test_files_import_one_another_in_one_direction():
    graph = {file.stem: imported(file) for file in FOLDER.glob("*.py") if file.stem != "__init__"}
    left = set(graph)
    while free := {name for name in left if not graph[name] & left}:
        left -= free
    assert left == set()
