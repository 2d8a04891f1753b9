"""Where a result comes from: code, packages, machine, kernels, command, time."""

import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import deformpush
from deformpush.record.checked import Text, checked
from deformpush.record.files import read_json
from deformpush.record.kernels import kernels

if TYPE_CHECKING:
    from pydantic import BaseModel

PROVENANCE_BYTES = 16_000_000
"""Largest provenance.json that is read: each time a run was taken up again adds some kilobytes."""


def provenance() -> dict[str, Any]:
    """Describe this process so that its run can be repeated and its numbers traced."""
    return {
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": shlex.join([Path(sys.executable).name, *sys.orig_argv[1:]]),
        "git": checkout(Path(deformpush.__file__).parents[1]),
        "python": platform.python_version(),
        "packages": packages(),
        "platform": platform.platform(),
        "machine": platform.machine(),
        "cpus": os.cpu_count(),
        "kernels": kernels(),
    }


def read_provenance(path: Path) -> dict[str, Any]:
    """Read a provenance.json; what another version added is kept.

    Raises:
        OSError: it cannot be read.
        ValueError: it is damaged, or a value is not what it should be; the message is one line.
    """
    return checked(read_json(path, PROVENANCE_BYTES), _model(), path.name)


def short_commit(git: Mapping[str, Any]) -> str:
    """What a provenance has under `git`, in short: seven letters, `+` behind where files differed from it."""
    return f"{git['commit'][:7]}{'+' if git['dirty'] else ''}"


@cache
def _model() -> "type[BaseModel]":
    """What provenance.json may hold."""
    from pydantic import BaseModel, ConfigDict, create_model

    settings: ConfigDict = {"strict": True, "extra": "allow"}
    git = create_model(
        "Git", __config__=settings, commit=(Text, ...), dirty=(bool, ...), changed=(list[Text], ...)
    )
    known: dict[str, Any] = dict.fromkeys(("time", "command", "python", "platform", "machine"), (Text, ""))
    known |= {"git": (git | None, None), "packages": (dict[Text, Text], {}), "cpus": (int | None, None)}
    library = create_model(
        "Library",
        __config__=settings,
        library=(Text, ...),
        version=(Text | None, ...),
        kernel=(Text | None, ...),
        threads=(int, ...),
    )
    known["kernels"] = (
        create_model(
            "Kernels",
            __config__=settings,
            blas=(list[library], ...),  # type: ignore[valid-type]
            numpy=(list[Text], ...),
            opencv=(Text, ""),
            torch=(Text, ""),
        )
        | None,
        None,
    )
    part: type[BaseModel] = create_model("Part", __config__=settings, after=(int, 0), **known)
    return create_model("Provenance", __base__=part, resumed=(list[part], []))  # type: ignore[valid-type]


def packages() -> dict[str, str]:
    """Name and version of every installed distribution, sorted by name."""
    # `item.name` and `item.version` would each read and parse the file anew.
    read = [item.metadata for item in metadata.distributions()]
    found = {item["Name"]: item["Version"] for item in read}
    return dict(sorted(found.items(), key=lambda pair: pair[0].lower()))


def checkout(root: Path) -> dict[str, Any] | None:
    """Commit of the checkout at `root` and the files that differ from it; None where `root` is none.

    An installed wheel may lie somewhere below an unrelated repository, so `root` itself must be the top.
    """
    if not (root / ".git").exists():
        return None
    commit = _git(root, "rev-parse", "HEAD")
    changes = _git(root, "status", "--porcelain")
    if commit is None or changes is None:
        return None
    changed = [line[3:] for line in changes.splitlines()]
    return {"commit": commit.strip(), "dirty": bool(changed), "changed": changed}


def _git(root: Path, *arguments: str) -> str | None:
    try:
        result = subprocess.run(
            ["git", "-C", str(root), *arguments], capture_output=True, text=True, timeout=10, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return result.stdout
