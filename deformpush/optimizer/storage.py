"""An optimizer's state in one file: plain arrays and JSON, nothing that runs code when it is read."""

import json
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np


def save(path: Path, state: Mapping[str, Any], sync: bool = True) -> None:
    """Write what `Optimizer.state()` returned to an `.npz` file; it appears whole or not at all.

    With `sync` it is on the disk when this returns, and so survives a power cut too.
    """
    arrays = {name: value for name, value in state.items() if isinstance(value, np.ndarray)}
    facts = {name: value for name, value in state.items() if name not in arrays}
    part = path.with_name(path.name + ".part")
    with part.open("wb") as file:
        np.savez(file, allow_pickle=False, json=np.array(json.dumps(facts)), **arrays)
        if sync:
            file.flush()
            os.fsync(file.fileno())
    os.replace(part, path)


def load(path: Path) -> dict[str, Any]:
    """Read what `save` wrote, for `Optimizer.restore()`.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the file is not one of ours, or damaged.
    """
    try:
        with path.open("rb") as whole, np.load(whole, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return json.loads(str(arrays.pop("json"))) | arrays
    except (KeyError, EOFError, ValueError, BadZipFile, zlib.error) as error:
        raise ValueError(f"restore: {path} is not a whole optimizer state ({error})") from None
