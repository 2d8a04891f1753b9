"""How far a run is, told by its folder alone: done, running, interrupted, failed, refused or not begun."""

import json
from dataclasses import dataclass
from typing import Any, Literal

from deformpush.record.folder import REFUSED, RESULTS, RunFolder
from deformpush.record.lock import held

RunState = Literal["done", "running", "interrupted", "failed", "refused", "pending"]
STATES: tuple[RunState, ...] = ("done", "running", "interrupted", "failed", "refused", "pending")


@dataclass(frozen=True)
class RunStatus:
    """What a folder tells at first glance; nothing in it is trusted to be whole."""

    state: RunState
    text: str
    """The status, or why it is not done, in one line."""
    pushes: int = 0
    summary: dict[str, Any] | None = None
    """The contents of summary.json."""


def run_status(folder: RunFolder) -> RunStatus:
    """Look at a run folder, without reading tables or settings where summary.json says it all."""
    if held(folder.path):
        return RunStatus("running", "running", _rows(folder))
    try:
        found = json.loads(folder.summary.read_bytes())
        status, reason, pushes = str(found["status"]), str(found["reason"]), int(found["pushes"])
    except FileNotFoundError:
        return _without_end(folder)
    except (OSError, ValueError, KeyError, TypeError):
        return RunStatus("interrupted", f"{folder.summary.name} is damaged", _rows(folder))
    if status in ("failed", "interrupted"):
        return RunStatus("failed" if status == "failed" else "interrupted", reason, pushes, found)
    return RunStatus("done", f"{status} after {pushes} push{'' if pushes == 1 else 'es'}", pushes, found)


def _without_end(folder: RunFolder) -> RunStatus:
    if any((folder.path / name).exists() for name in RESULTS):
        return RunStatus("interrupted", f"no {folder.summary.name}: it was killed", _rows(folder))
    try:
        reason = (folder.path / REFUSED).read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return RunStatus("pending", "not begun")
    return RunStatus("refused", reason or "refused")


def _rows(folder: RunFolder) -> int:
    """Pushes in the table so far; 0 where it cannot be read."""
    try:
        return max(0, folder.table.read_bytes().count(b"\n") - 2)
    except OSError:
        return 0
