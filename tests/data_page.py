"""docs/data.md as tables, and how what it says is held against what is there."""

import csv
import json
from collections.abc import Iterable, Mapping
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import yaml

from tests import pages

PAGE = pages.page("docs/data.md")
SECTIONS = pages.sections(PAGE)
KINDS = {
    "int": r"-?\d+",
    "float": r"-?(\d+\.\d+(e-?\d+)?|\d+e-\d+)",
    "text": r".+",
}
"""How a cell of a CSV looks."""
PYTHON = {
    "int": int,
    "float": float,
    "text": str,
    "bool": bool,
    "list": list,
    "mapping": dict,
    "null": type(None),
}


def rows(heading: str) -> list[dict[str, str]]:
    """The table below a heading; what its first column holds, without backticks, is called `name`."""
    found = pages.rows(SECTIONS[heading])
    return [{**row, "name": next(iter(row.values())).strip("`")} for row in found]


def holds(when: str, config: Mapping[str, Any]) -> bool:
    """Whether what a table says of a file or array is so in a run: `always`, `GROUP=OPTION`, `record.KEY`."""
    key, _, option = when.strip("`").partition("=")
    if option:
        return fnmatch(config["options"][key], option)
    return key == "always" or config["record"][key.removeprefix("record.")] is True


def agree(told: Iterable[str], found: Iterable[str], ordered: bool = True) -> None:
    """Every name is in both, and in the same order."""
    told, found = list(told), list(found)
    assert not set(found) - set(told), "not in docs/data.md"
    assert not set(told) - set(found), "in docs/data.md and nowhere else"
    assert not ordered or told == found, "in another order in docs/data.md"


def is_a(value: Any, kind: str) -> bool:
    """Whether a value of a JSON file is what a table says: `float or null`."""
    return any(type(value) is PYTHON[one] for one in kind.split(" or "))


class Made:
    """A fresh run and its files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.config = yaml.safe_load((folder / "config.yaml").read_text(encoding="utf-8"))
        self.summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))

    def table(self, name: str) -> tuple[list[str], list[list[str]]]:
        """Header and rows of a CSV file."""
        with (self.folder / name).open(encoding="utf-8", newline="") as file:
            header, *body = list(csv.reader(file))
        return header, body


class Shapes:
    """The letters of the tables' shapes; one that is not known takes the first size it meets."""

    def __init__(self, run: Made) -> None:
        pushes, initial = run.summary["pushes"], run.summary["initial_samples"]
        self.known = {
            "K": pushes,
            "S": pushes,
            "S0": initial,
            "M": run.config["contour"]["M"],
            "L": 0,
            "E": 3,
        }

    def fits(self, rule: str, shape: tuple[int, ...]) -> bool:
        """Whether a shape is as written, such as `(K+1, M, 2)`."""
        sizes = [part for part in rule.strip("()").split(",") if part.strip()]
        if len(sizes) != len(shape):
            return False
        for text, size in zip(sizes, shape, strict=True):
            parts = [part.strip() for part in text.split("+")]
            if len(parts) == 1 and not parts[0].isdecimal():
                self.known.setdefault(parts[0], size)
            if sum(int(p) if p.isdecimal() else self.known[p] for p in parts) != size:
                return False
        return True
