"""How far a run is, told by its folder alone: done, running, interrupted, failed, refused or not begun."""

from dataclasses import dataclass
from typing import Any, Literal

from deformpush.record.files import JSON_BYTES, TABLE_BYTES, read_bytes
from deformpush.record.folder import REFUSED, RESULTS, RunFolder
from deformpush.record.lock import held
from deformpush.record.summary import counted, read_known

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
    """The contents of summary.json that this version knows."""


def run_status(folder: RunFolder) -> RunStatus:
    """Look at a run folder, without reading tables or settings where summary.json says it all."""
    if held(folder.path):
        return RunStatus("running", "running", _rows(folder))
    try:
        found = read_known(folder)
        status, reason, pushes = found["status"], found["reason"], found["pushes"]
    except FileNotFoundError:
        return _without_end(folder)
    except OSError as error:
        why = f"{folder.summary.name} cannot be read ({error.strerror})"
        return RunStatus("interrupted", why, _rows(folder))
    except ValueError as error:
        return RunStatus("interrupted", str(error), _rows(folder))
    except KeyError as error:
        return RunStatus(
            "interrupted", f"{folder.summary.name} is damaged: no {error.args[0]}", _rows(folder)
        )
    if status in ("failed", "interrupted"):
        return RunStatus("failed" if status == "failed" else "interrupted", reason, pushes, found)
    return RunStatus("done", f"{status} after {counted(pushes)}", pushes, found)


def _without_end(folder: RunFolder) -> RunStatus:
    if any((folder.path / name).exists() for name in RESULTS):
        return RunStatus("interrupted", f"no {folder.summary.name}: it was killed", _rows(folder))
    try:
        reason = read_bytes(folder.path / REFUSED, JSON_BYTES).decode(errors="replace").strip()
    except OSError:
        return RunStatus("pending", "not begun")
    return RunStatus("refused", reason or "refused")


def _rows(folder: RunFolder) -> int:
    """Pushes in the table so far; 0 where it cannot be read."""
    try:
        return max(0, read_bytes(folder.table, TABLE_BYTES).count(b"\n") - 2)
    except OSError:
        return 0
