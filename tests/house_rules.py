"""The rules of docs/architecture.md: which room may know which library and which room, and how large all is.

Each rule is a function that complains, a line a case; test_imports.py holds the package to them.
"""

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "deformpush"

MAY_IMPORT = {
    "errors": "",
    "extras": "errors",
    "mechanics": "",
    "gp": "mechanics",
    "cell": "mechanics",
    "outlines": "cell errors extras mechanics",
    "worlds": "cell mechanics",
    "task": "cell errors mechanics",
    "state": "cell mechanics task",
    "model": "gp mechanics state task",
    "push_record": "cell state task",
    "optimizer": "cell extras gp mechanics model state",
    "loop": "cell optimizer push_record state task",
    "record": "cell errors push_record state task",
    "viewer": "cell errors mechanics push_record record state task",
    "study": "errors push_record record task viewer",
    "config": "errors extras",
    "experiment": (
        "cell config errors extras gp loop mechanics model optimizer push_record record state study task "
        "viewer"
    ),
    "checks": "cell config errors experiment mechanics worlds",
    "cli": "cell checks config errors experiment extras loop outlines push_record record study viewer",
    "__init__": "cell errors experiment optimizer state",
    "__main__": "cli config errors",
}
"""By room, which are the files and folders directly under deformpush/: the rooms it may know."""

ROOMS, FLOORS, LINES, SPELLINGS = 24, 12, 300, 6

ANYWHERE = {"numpy", "annotated_types"}
ONLY_IN = {
    "argparse": "cli",
    "av": "study.film",
    "botorch": "optimizer.rivals",
    "cmaes": "optimizer.rivals",
    "contourpy": "outlines.trace",
    "cv2": "cell outlines record viewer worlds experiment.assemble",
    "ezdxf": "outlines.dxf",
    "gpytorch": "optimizer.rivals",
    "hydra": "cli.launch config experiment.sweep experiment.tuning",
    "hydra_plugins": "experiment.sweep",
    "matplotlib": "study experiment.api outlines.overlay",
    "mujoco": "worlds.mujoco checks.mujoco",
    "omegaconf": "cli.launch config experiment.setup experiment.sweep experiment.tuning",
    "optuna": "optimizer.rivals experiment.tuning cli.tune",
    "pandas": "record study experiment.api",
    "pyarrow": "viewer",
    "pybullet": "worlds.bullet",
    "pybullet_data": "worlds.bullet",
    "pybullet_utils": "worlds.bullet",
    "pydantic": "config.schema record experiment.sweep.manifest",
    "ray": "experiment.sweep",
    "rerun": "viewer",
    "rerun_cli": "viewer",
    "scipy": "gp mechanics model optimizer",
    "shapely": "outlines",
    "submitit": "experiment.sweep",
    "svgelements": "outlines.svg",
    "threadpoolctl": "experiment.one_thread record.kernels",
    "torch": "optimizer",
    "tqdm": "experiment.console",
    "trimesh": "outlines.solid",
    "yaml": "cli.launch cli.object config record",
}
"""By library: the rooms, and modules of rooms, that may import it, at once or where it is needed."""

MATHEMATICS = ("mechanics", "gp", "model", "optimizer")
TYPED = {"world", "scenery", "state", "outcome", "before", "after"}
"""What is called so is a `World`, `Scenery`, `State`, `Outcome`, `State`, `State`."""

Modules = dict[tuple[str, ...], str]
"""Texts by dotted path: ("optimizer", "rivals", "greedy")."""


@cache
def text_of(file: Path) -> str:
    return file.read_text(encoding="utf-8")


def modules(package: Path) -> Modules:
    return {
        file.relative_to(package).with_suffix("").parts: text_of(file)
        for file in sorted(package.rglob("*.py"))
    }


@cache
def tree(text: str) -> ast.Module:
    return ast.parse(text)


@cache
def imported(text: str) -> frozenset[tuple[str, ...]]:
    """Dotted paths of what a module imports anywhere in it, also by name and for type checkers only."""
    found = set()
    for node in ast.walk(tree(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{'.' * node.level}{node.module or ''}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            by_name = ast.unparse(node.func).split(".")[-1] in ("library", "import_module", "__import__")
            found |= {str(node.args[0].value)} if by_name else set()
    return frozenset(tuple(name.split(".")) for name in found)


def within(path: tuple[str, ...], places: str) -> bool:
    """Whether a module is one of these places or lies in one; whole components count, not letters."""
    return any(path[: len(place)] == place for place in (tuple(p.split(".")) for p in places.split()))


def libraries(text: str) -> set[str]:
    return {name[0] for name in imported(text)} - {"deformpush"}


def arrows(found: Modules) -> dict[str, set[str]]:
    """By room: the other rooms it imports. What is no room is of `__init__`, but for `__version__`."""
    rooms: dict[str, set[str]] = {path[0]: set() for path in found}
    for path, text in found.items():
        known = {name[1] for name in imported(text) if name[0] == "deformpush" and len(name) > 1}
        known = {name if name in rooms else "__init__" for name in known if not name.startswith("__")}
        rooms[path[0]] |= known - {path[0]}
    return rooms


def library_outside_its_rooms(found: Modules) -> Iterator[str]:
    """A library is known in few rooms: Rerun in viewer/, engines in worlds/, verbs' flags in cli/."""
    for path, text in found.items():
        for name in libraries(text) & set(ONLY_IN):
            if not within(path, ONLY_IN[name]):
                yield f"{'/'.join(path)} imports {name}"


def library_without_a_room(found: Modules) -> Iterator[str]:
    """A new library gets its rooms in the table above."""
    for path, text in found.items():
        for name in libraries(text) - set(ONLY_IN) - ANYWHERE - set(sys.stdlib_module_names):
            yield f"{'/'.join(path)} imports {name or 'something relative to itself'}"


def import_of_another_room(found: Modules) -> Iterator[str]:
    """A room knows the rooms below it that the table allows."""
    for room, known in arrows(found).items():
        for other in known - set(MAY_IMPORT.get(room, "").split()):
            yield f"{room} imports {other}"


def room_without_a_row(found: Modules) -> Iterator[str]:
    """The table names every room, and no other."""
    yield from {path[0] for path in found} ^ set(MAY_IMPORT)


def recorder_in_the_loop(found: Modules) -> Iterator[str]:
    """The loop calls whoever listens; it knows no recorder."""
    for name in imported(found[("loop",)]):
        if name[0] == "deformpush" and name[1] in ("record", "viewer", "study", "experiment", "config"):
            yield ".".join(name)


def verb_outside_cli(found: Modules) -> Iterator[str]:
    """What takes a command line stands in cli/, and every verb is a module there."""
    for path, text in found.items():
        mains = [
            node
            for node in tree(text).body
            if isinstance(node, ast.FunctionDef) and node.name == "main" and node.args.args
        ]
        if mains and path[0] != "cli":
            yield f"{'/'.join(path)} has a main(argv)"
    from deformpush.cli.usage import VERBS

    yield from (f"cli/{verb} is missing" for verb in VERBS if ("cli", verb) not in found)


def engine_outside_worlds(found: Modules) -> Iterator[str]:
    """Worlds are named in YAML; only checks/, which examines Bullet, knows one."""
    for path, text in found.items():
        worlds = {name for name in imported(text) if name[:2] == ("deformpush", "worlds")}
        if worlds and path[0] not in ("worlds", "checks"):
            yield f"{'/'.join(path)} imports {worlds}"


def mathematics_that_sees(found: Modules) -> Iterator[str]:
    """mechanics/ gp/ model/ optimizer/ serve a real cell as they stand: arrays, and no camera or engine."""
    plain = {("observation",), ("push",), ("world",)}
    for path, text in found.items():
        if path[0] in MATHEMATICS:
            for name in libraries(text) & {"cv2", "pybullet", "hydra", "omegaconf", "rerun", "pydantic"}:
                yield f"{'/'.join(path)} imports {name}"
            for name in imported(text):
                if name[:2] == ("deformpush", "cell") and name[2:3] not in plain:
                    yield f"{'/'.join(path)} imports {'.'.join(name)}"


def circle(found: Modules) -> Iterator[str]:
    """No room knows itself through others."""
    graph, left = arrows(found), set(arrows(found))
    while free := {room for room in left if not graph[room] & left}:
        left -= free
    yield from left


def too_many_rooms_or_floors(found: Modules) -> Iterator[str]:
    """A newcomer holds it in mind."""
    graph = arrows(found)

    def floor(room: str, above: tuple[str, ...] = ()) -> int:
        return 1 + max((floor(r, (*above, room)) for r in graph[room] if r not in above), default=0)

    if len(graph) > ROOMS:
        yield f"{len(graph)} rooms"
    if (highest := max(map(floor, graph))) > FLOORS:
        yield f"{highest} floors"


def file_too_long(found: Modules) -> Iterator[str]:
    """One file, one purpose."""
    for path, text in found.items():
        if (lines := text.count("\n")) > LINES:
            yield f"{'/'.join(path)}: {lines} lines"
    if (lines := found[("loop",)].count("\n")) > LINES / 2:
        yield f"loop: {lines} lines"


def error_spelt_out(found: Modules) -> Iterator[str]:
    """The errors are one table, `task.TERMS`."""
    files = [path for path, text in found.items() if "e_gamma" in text]
    if len(files) > SPELLINGS:
        yield from ("/".join(path) for path in files)


def untyped_contract(found: Modules) -> Iterator[str]:
    """A world, a scenery, a state and an outcome have types."""
    for path, text in found.items():
        for node in ast.walk(tree(text)):
            name, hint = None, None
            if isinstance(node, ast.arg):
                name, hint = node.arg, node.annotation
            elif isinstance(node, ast.AnnAssign):
                name, hint = ast.unparse(node.target).split(".")[-1], node.annotation
            elif isinstance(node, ast.FunctionDef):
                name, hint = node.name, node.returns
            parts = re.split(r"\s*\|\s*", ast.unparse(hint).strip("'\"")) if hint else []
            if name in TYPED and {"Any", "typing.Any", "object"} & set(parts):
                yield f"{'/'.join(path)}, line {node.lineno}: {name} is {ast.unparse(hint)}"
