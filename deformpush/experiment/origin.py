"""In what the process that made a push differed from this one, as far as its provenance.json says."""

import re
from collections.abc import Iterator, Mapping
from importlib import metadata
from typing import Any

from deformpush.errors import shortened
from deformpush.record.folder import PROVENANCE, RunFolder
from deformpush.record.provenance import provenance, read_provenance, short_commit

SHOWN = 6
"""Differences that are named."""
LONGEST = 60
"""Letters that are shown of what a file says."""


def origin(folder: RunFolder, k: int) -> str:
    """One line about where push k of a run was made, held against this process."""
    try:
        then = read_provenance(folder.path / PROVENANCE)
    except FileNotFoundError:
        return f"where it was made is not known: no {PROVENANCE}"
    except (OSError, ValueError) as error:
        return f"where it was made is not known: {error}"
    for part in then.get("resumed", []):
        if part.get("after", 0) < k:
            then = part
    found = list(differing(then, provenance()))
    if not found:
        told = "versions and kernels" if then.get("kernels") else "versions (its kernels are not told)"
        return f"made with the same {told} as here: a file or the code was changed, or a C library differs"
    more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return f"made with {', '.join(found[:SHOWN])}{more}: which may be the reason"


def differing(then: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Name what differs of two provenances and can change a number; what one does not tell is left out.

    The code comes first, then kernels, then versions of Python, processor and the packages needed.
    """
    commits = [short_commit(git) if (git := part.get("git")) else "" for part in (then, now)]
    if all(commits) and (commits[0] != commits[1] or commits[0].endswith("+")):
        yield _pair("code", *commits)
    kernels = [_kernels(part.get("kernels") or {}) for part in (then, now)]
    yield from _pairs(*kernels)
    for name in ("python", "machine"):
        if then.get(name) and then[name] != now[name]:
            yield _pair(name, then[name], now[name])
    needed = _needed()
    versions = [
        {name: version for name, version in part.get("packages", {}).items() if _plain(name) in needed}
        for part in (then, now)
    ]
    yield from _pairs(*versions)


def _kernels(found: Mapping[str, Any]) -> dict[str, str]:
    """By library: what it computes with."""
    named = {
        f"BLAS {one['library'].partition('-')[0]}": f"{one['kernel']}, {one['threads']} thread(s)"
        for one in found.get("blas", [])
    }
    if "numpy" in found:
        named["numpy's instructions"] = " ".join(found["numpy"]) or "none"
    return named | {f"{name}'s instructions": found[name] for name in ("opencv", "torch") if name in found}


def _pairs(then: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    for name in then:
        if name in now and then[name] != now[name]:
            yield _pair(name, then[name], now[name])


def _pair(name: str, then: str, now: str) -> str:
    return f"{name} {shortened(' '.join(then.split()), LONGEST)} (here {now})"


def _needed() -> set[str]:
    """The packages that deformpush runs with, extras included, and itself."""
    try:
        needed = metadata.requires("deformpush") or []
    except metadata.PackageNotFoundError:
        needed = []
    used = [text for text in needed if not re.search(r"extra == .dev\b", text)]
    return {"deformpush", *(_plain(re.split(r"[^\w.-]", text, maxsplit=1)[0]) for text in used)}


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
