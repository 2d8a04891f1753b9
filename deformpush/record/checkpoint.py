"""An optimizer's state in a file, plain arrays and JSON, and checkpoint.npz, where a run keeps its newest."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from deformpush.record.npz import read_npz, write_npz


class Checkpoint(NamedTuple):
    """An optimizer's state and the push it follows."""

    k: int
    state: dict[str, Any]


def save(path: Path, state: Mapping[str, Any], sync: bool = True) -> None:
    """Write what `Optimizer.state()` returned to an .npz file.

    With `sync` it is on the disk when this returns, and so survives a power cut too.
    """
    arrays = {name: value for name, value in state.items() if isinstance(value, np.ndarray)}
    facts = {name: value for name, value in state.items() if name not in arrays}
    write_npz(path, {"json": np.array(json.dumps(facts)), **arrays}, sync)


def load(path: Path) -> dict[str, Any]:
    """Read what `save` wrote, for `Optimizer.restore()`.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the file is not one of ours, or damaged.
    """
    try:
        arrays = read_npz(path)
        return json.loads(str(arrays.pop("json"))) | arrays
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise ValueError(f"restore: {path} is not a whole optimizer state ({error})") from None


def is_due(k: int) -> bool:
    """Whether a checkpoint is written after push k: each time, later once for every hundredth part more.

    What an optimizer knows grows with the pushes, and with it the time to write it down. After push 2,000 at
    most 19 decisions are thought over again.
    """
    return k % max(1, k // 100) == 0


def write(path: Path, k: int, state: Mapping[str, Any]) -> None:
    """Replace the checkpoint. It is not forced to the disk: a run without one is resumed all the same."""
    save(path, {"k": k, **{f"state.{name}": value for name, value in state.items()}}, sync=False)


def read(path: Path) -> Checkpoint | None:
    """The checkpoint, or None where there is none that is whole: the pushes can be thought over again."""
    try:
        found = load(path)
        state = {name.removeprefix("state."): v for name, v in found.items() if name.startswith("state.")}
        return Checkpoint(int(found["k"]), state)
    except (OSError, ValueError, TypeError, KeyError):
        return None
