"""sweep.json: which runs a sweep consists of, written before the first begins."""

import json
import shlex
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path, PurePath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pydantic import BaseModel

SWEEP = "sweep.json"
SWEEP_BYTES = 64_000_000
"""Largest sweep.json that is read: some 100,000 runs."""


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
    from deformpush.record.files import write_whole

    listed = {job.name: job for job in [*read(folder), *jobs]}
    command = shlex.join(["python", "-m", "deformpush", *sys.argv[1:]])
    content = {"command": command, "jobs": [asdict(job) for job in listed.values()]}
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / SWEEP, json.dumps(content, indent=1).encode())


def read(folder: Path) -> list[Job]:
    """The runs that sweep.json lists; none where there is no such file, or it is damaged.

    Nor are there any where one is said to lie outside of the folder: nobody would look for a run there.
    """
    from deformpush.record.checked import checked
    from deformpush.record.files import read_json

    try:
        jobs = checked(read_json(folder / SWEEP, SWEEP_BYTES), _model(), SWEEP)["jobs"]
    except (OSError, ValueError):
        return []
    names = [PurePath(job["name"]) for job in jobs]
    if any(name.is_absolute() or ".." in name.parts or not name.parts or "\0" in str(name) for name in names):
        return []
    return [Job(job["name"], job["overrides"]) for job in jobs]


@cache
def _model() -> "type[BaseModel]":
    """What sweep.json may hold."""
    from pydantic import ConfigDict, create_model

    from deformpush.record.checked import Text

    settings: ConfigDict = {"strict": True, "extra": "allow"}
    job = create_model("Job", __config__=settings, name=(Text, ...), overrides=(list[Text], ...))
    return create_model("Sweep", __config__=settings, jobs=(list[job], ...))  # type: ignore[valid-type]
