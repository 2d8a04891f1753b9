"""world_states.bin: the state of the world after every push, where it can be saved, to go on from anywhere.

A row of blocks (see `blocks`), one for each k = 0, 1, ...: k (unsigned 64-bit) and the simulated seconds
since the run began (float64), little-endian, then what `World.save` returned. Appended while the run goes
on, and kept when it has ended.
"""

import math
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryFile
from typing import BinaryIO, NamedTuple

from deformpush.record.blocks import FILE_BYTES, HEAD, block, blocks
from deformpush.record.files import append, open_file, replacing, to_append, write_whole

BEFORE = struct.Struct("<Qd")
"""What stands before the state in each block."""
COPIED = 1_000_000
"""Bytes that are copied at a time."""


class WorldState(NamedTuple):
    """What the world was after a push."""

    k: int
    sim_time_s: float
    """Simulated seconds since the run began."""
    state: bytes
    """As `World.save` gave it."""


class WorldStatesWriter:
    """Appends the state of a world to the file, which is opened once and never read again.

    What is made again of a run that is taken up stays aside until `go_on`: until then the file is as it was.
    """

    def __init__(self, path: Path, save: Callable[[], bytes]) -> None:
        """`save` is `World.save`. Nothing is written yet."""
        self._path, self._save = path, save
        self._file: BinaryIO | None = None
        self._aside: BinaryIO | None = None

    def begin(self) -> None:
        """Begin an empty file in place of the one there may be.

        Raises:
            OSError: no room or no permission.
        """
        write_whole(self._path, b"", sync=False)
        self._file = to_append(self._path)

    def append(self, k: int, sim_time_s: float) -> None:
        """Append the state now, whole or not at all. It is not forced to the disk: runs go on without it too.

        Raises:
            OSError: no room for it.
        """
        assert self._file is not None, "begin or go_on comes first"
        append(self._file, self._block(k, sim_time_s), sync=False)

    def put_aside(self, k: int, sim_time_s: float) -> None:
        """Keep the state now for `go_on`, in a file that has no name."""
        if self._aside is None:
            self._aside = TemporaryFile(dir=self._path.parent)  # noqa: SIM115 - held until `close`
        self._aside.write(self._block(k, sim_time_s))

    def go_on(self, pushes: int | None) -> None:
        """Keep the file up to the state after push `pushes`, or none of it, and add what was put aside."""
        if pushes is None:
            self.begin()
        else:
            size = sum(HEAD.size + BEFORE.size + len(one.state) for one in states(self._path, pushes))
            self._file = to_append(self._path, size)
        if self._aside is not None:
            self._aside.seek(0)
            while data := self._aside.read(COPIED):
                assert self._file is not None
                append(self._file, data, sync=False)
            self._aside.close()

    def close(self) -> None:
        """Release the file."""
        for file in (self._file, self._aside):
            if file is not None:
                file.close()

    def _block(self, k: int, sim_time_s: float) -> bytes:
        return _packed(WorldState(k, sim_time_s, self._save()))


def states(path: Path, most: int | None = None) -> Iterator[WorldState]:
    """The states from k = 0 to `most`, or to the last one before which none is missing or damaged.

    Raises:
        OSError: the file cannot be read.
    """
    with open_file(path, FILE_BYTES) as file:
        for k, data in enumerate(blocks(file)):
            if len(data) < BEFORE.size or (most is not None and k > most):
                return
            found, sim_time_s = BEFORE.unpack_from(data)
            if found != k or not math.isfinite(sim_time_s):
                return
            yield WorldState(k, sim_time_s, data[BEFORE.size :])


def _packed(one: WorldState) -> bytes:
    return block(BEFORE.pack(one.k, one.sim_time_s) + one.state)


def newest(path: Path, most: int) -> WorldState | None:
    """The last state that follows push `most` or an earlier one; None where there is none.

    Raises:
        OSError: the file cannot be read.
    """
    last: WorldState | None = None
    for one in states(path, most):
        last = one
    return last


def copy(source: Path, path: Path, most: int) -> None:
    """Replace a file by the states of another one up to push `most`.

    Raises:
        OSError: one cannot be read, or no room for the other.
    """
    with replacing(path) as temporary, temporary.open("wb") as file:
        for one in states(source, most):
            file.write(_packed(one))
