"""checkpoint.npz: what the optimizer knew after push k, so that `resume` need not think again."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from deformpush.optimizer.storage import load, save


class Checkpoint(NamedTuple):
    """An optimizer's state and the push it follows."""

    k: int
    state: dict[str, Any]


def write(path: Path, k: int, state: Mapping[str, Any]) -> None:
    """Replace the checkpoint. It is not forced to the disk: a run without one is resumed all the same."""
    save(path, {"k": k, **{f"state.{name}": value for name, value in state.items()}}, sync=False)


def read(path: Path) -> Checkpoint | None:
    """The checkpoint, or None where there is none that is whole: the pushes can be thought over again."""
    try:
        found = load(path)
        state = {name.removeprefix("state."): v for name, v in found.items() if name.startswith("state.")}
        return Checkpoint(int(found["k"]), state)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None
