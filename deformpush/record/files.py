"""The two ways to touch a file of a run: it is read if it is a plain one of a sane size, and written whole.

A run folder may come from anywhere. So a link is neither followed nor written through, and what is not a
regular file (a pipe, a device) is not even opened.
"""

import errno
import json
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, cast

TABLE_BYTES = 64_000_000
"""Largest CSV that is read: some 200,000 pushes."""
JSON_BYTES = 1_000_000
"""Largest JSON and YAML that is read."""
FIGURE_BYTES = 64_000_000
"""Largest picture that is read."""

OPENED = os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
"""How a file of a run is opened: never through a link, and never waiting for a pipe's other end."""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary file beside `path`, of the same suffix, that takes its place when the block ends well.

    A reader, or a crash, meets the old file or the new one, never a part; no temporary file stays.
    """
    temporary = path.with_name(f".{path.stem}.{secrets.token_hex(4)}.tmp{path.suffix}")
    os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | OPENED, 0o666))
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
            synced(file)


def synced(file: BinaryIO) -> None:
    """Wait until the disk has what was written."""
    file.flush()
    os.fsync(file.fileno())


def append(file: BinaryIO, data: bytes, sync: bool) -> None:
    """Add `data` at the end of an unbuffered file that `to_append` opened, whole or not at all.

    Raises:
        OSError: no room for it.
    """
    at, left = file.tell(), memoryview(data)
    try:
        while left:  # where the disk becomes full in the middle of it, only the next attempt says so
            left = left[file.write(left) :]
        if sync:
            os.fsync(file.fileno())
    except OSError:
        file.truncate(at)
        file.seek(at)
        raise


def to_append(path: Path, size: int | None = None) -> BinaryIO:
    """Open a file of a run, unbuffered, to go on at its end, or behind its first `size` bytes.

    Raises:
        OSError: it is not there, a link, or no regular file.
    """
    file = _opened(path, os.O_RDWR, "r+b")
    if size is not None:
        file.truncate(size)
    file.seek(0, os.SEEK_END)
    return file


def open_file(path: Path, most: int) -> BinaryIO:
    """Open a file of a run to read it.

    Raises:
        FileNotFoundError: there is none.
        OSError: it cannot be read, is a link, no regular file, or larger than `most` bytes.
    """
    file = _opened(path, os.O_RDONLY, "rb")
    if os.fstat(file.fileno()).st_size > most:
        file.close()
        raise OSError(errno.EFBIG, f"larger than {most / 1e6:g} MB", str(path))
    return file


def read_bytes(path: Path, most: int) -> bytes:
    """All bytes of a file of a run; errors as in `open_file`."""
    with open_file(path, most) as file:
        return file.read(most)


def read_json(path: Path, most: int = JSON_BYTES) -> Any:
    """What a JSON file of a run says.

    Raises:
        OSError: as in `open_file`.
        ValueError: it is not JSON; the message is one line.
    """
    try:
        return json.loads(read_bytes(path, most), parse_constant=_no_number)
    except (ValueError, RecursionError):
        raise ValueError(f"{path.name} is damaged: not JSON") from None


def _opened(path: Path, flags: int, mode: str) -> BinaryIO:
    if not stat.S_ISREG(os.lstat(path).st_mode):  # before it is opened: that alone may do things to a device
        raise _not_regular(path)
    handle = os.open(path, flags | OPENED)
    file = cast("BinaryIO", os.fdopen(handle, mode, buffering=0 if flags & os.O_RDWR else -1))
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):  # it was another one a moment ago
        file.close()
        raise _not_regular(path)
    return file


def _not_regular(path: Path) -> OSError:
    kind = "a symbolic link" if path.is_symlink() else "no regular file"
    return OSError(errno.EINVAL, kind, str(path))


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no JSON")
