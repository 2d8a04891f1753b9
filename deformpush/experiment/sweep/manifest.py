"""sweep.json: which runs a sweep consists of, written before the first begins."""

import json
import shlex
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from deformpush.record.files import read_json, write_whole

SWEEP = "sweep.json"
LARGEST = 100_000_000
"""Bytes of it that are read: some hundred thousand runs."""


@dataclass(frozen=True)
class Job:
    """One run of a sweep."""

    name: str
    """Of its folder below that of the sweep."""
    overrides: list[str]


def write(folder: Path, jobs: Iterable[Job]) -> None:
    """Write sweep.json; runs that it lists already, of earlier commands into the same folder, stay listed.

    Raises:
        OSError: the folder cannot be made or written.
    """
    listed = {job.name: job for job in [*read(folder), *jobs]}
    command = shlex.join(["python", "-m", "deformpush", *sys.argv[1:]])
    content = {"command": command, "jobs": [asdict(job) for job in listed.values()]}
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / SWEEP, json.dumps(content, indent=1).encode())


def read(folder: Path) -> list[Job]:
    """The runs that sweep.json lists below its folder; none where there is no such file, or it is damaged."""
    try:
        found = read_json(folder / SWEEP, LARGEST)
        jobs = [Job(str(job["name"]), [str(text) for text in job["overrides"]]) for job in found["jobs"]]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [job for job in jobs if _below(job.name)]


def _below(name: str) -> bool:
    """Whether a folder of this name lies inside that of the sweep."""
    path = Path(name)
    return not path.is_absolute() and ".." not in path.parts and "\0" not in name
