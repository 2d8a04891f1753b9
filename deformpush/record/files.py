"""Files that appear whole or not at all: bytes, and arrays as .npz."""

import io
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

DAMAGE = (BadZipFile, EOFError, KeyError, MemoryError, RuntimeError, TypeError, ValueError, zlib.error)
"""What reading a damaged .npz file may raise, whichever of its bytes are not as they were."""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary file beside `path`, of the same suffix, that takes its place when the block ends well.

    A reader, or a crash, meets the old file or the new one, never a part; no temporary file stays.
    """
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.tmp{path.suffix}")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes, sync: bool = True) -> None:
    """Replace a file by `data`.

    Args:
        path: the file.
        data: all it shall hold.
        sync: wait until the disk has it, so that it survives a power cut too, not only a killed process.

    Raises:
        OSError: no room or no permission; the old file is untouched.
    """
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(data)
        if sync:
            file.flush()
            os.fsync(file.fileno())


def write_npz(path: Path, arrays: Mapping[str, Any], sync: bool = True) -> None:
    """Replace an .npz file by arrays, or what makes arrays, by name; otherwise as `write_whole`."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    write_whole(path, buffer.getvalue(), sync)


def read_npz(path: Path, names: Sequence[str] | None = None) -> dict[str, Any]:
    """Read the arrays of an .npz file by name, all of them or those named. Nothing in it is run.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged, another kind of file, or lacks an array.
    """
    try:
        with path.open("rb") as handle, np.load(handle, allow_pickle=False) as file:
            return {name: file[name] for name in (file.files if names is None else names)}
    except DAMAGE as error:
        raise ValueError(f"{path}: damaged, or not written by a run ({error})") from error
