"""Finds the finished runs that a command line names, and says why others are left out."""

import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from deformpush.errors import UserError
from deformpush.record.finished import FinishedRun, NotFinishedError, read
from deformpush.record.folder import CONFIG, PROVENANCE, SUMMARY, TABLE, RunFolder

MARKS = (CONFIG, PROVENANCE, TABLE, SUMMARY)
"""A folder that holds one of these is a run's, finished or not."""


@dataclass(frozen=True)
class FoundRuns:
    """Runs in the order they were named, by number inside a sweep, and what was left out."""

    runs: list[FinishedRun]
    skipped: list[tuple[str, str]]
    """Name and reason."""


def find_runs(paths: Sequence[str | Path]) -> FoundRuns:
    """Read every run among `paths`, which are run folders or folders with runs somewhere below.

    Raises:
        UserError: no finished run is among them.
    """
    found = {folder.resolve(): folder for path in paths for folder in run_folders(Path(path))}
    names = _names([Path(path) for path in paths], list(found.values()))
    runs: list[FinishedRun] = []
    skipped: list[tuple[str, str]] = []
    for folder, name in zip(found.values(), names, strict=True):
        try:
            runs.append(read(RunFolder(folder), name))
        except NotFinishedError as problem:
            skipped.append((name, str(problem)))
    if not runs:
        why = "; ".join(f"{name}: {reason}" for name, reason in skipped[:3])
        raise UserError(f"no finished run among {', '.join(map(str, paths))} ({why})")
    return FoundRuns(runs, skipped)


def is_run(folder: Path) -> bool:
    """Whether the folder is, or was begun as, a run's."""
    return any((folder / mark).exists() for mark in MARKS)


def run_folders(path: Path) -> list[Path]:
    """Run folders at or below `path`; `path` itself where there is none, so that it can be named."""
    if is_run(path) or not path.is_dir():
        return [path]
    found = []
    for here, below, _ in os.walk(path):
        below[:] = [name for name in below if not name.startswith(".")]
        for name in list(below):
            if is_run(Path(here, name)):
                found.append(Path(here, name))
                below.remove(name)
    return sorted(found, key=lambda one: natural(str(one))) or [path]


def natural(text: str) -> list[tuple[int, int, str]]:
    """Sort key by which seed=2 comes before seed=10."""
    parts = [part for part in re.split(r"(\d+)", text) if part]
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts]


def _names(given: Iterable[Path], folders: Sequence[Path]) -> list[str]:
    """Shortest paths that tell the runs apart: relative to what they have in common."""
    above = [folder.resolve().parent for folder in folders]
    common = Path(os.path.commonpath(above)) if above else Path()
    return [str(folder.resolve().relative_to(common)) for folder in folders]
