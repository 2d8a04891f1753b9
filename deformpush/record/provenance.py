"""Where a result comes from: code, packages, machine, command, time."""

import os
import platform
import shlex
import subprocess
import sys
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

import deformpush


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
    }


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
