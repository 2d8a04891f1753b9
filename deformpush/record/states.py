"""states.bin: outline, pose and picture after every push, appended while a run goes on.

When the run closes, contours.npz and views.npz are made of it (see `poses`). It is a row of blocks (see
`blocks`). The first is a JSON text: `M`, the number of contour points, and `fixed`, the arrays that stay the
same. Every other block is a state: the float64 numbers c (2), theta, start (2), end (2), contour (2 M), then
the picture (JPEG).
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from deformpush.push_record import PushRecord
from deformpush.record.blocks import FILE_BYTES, block, blocks
from deformpush.record.files import append, open_file, replacing, synced, to_append

POINTS, COUNT = range(3, 100_001), 1_000_000
"""M, and the number of states, as far as they are read."""

HEADLESS = (StopIteration, ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError)
"""What reading a damaged first block may raise."""
NUMBERS = {"c": 2, "theta": 1, "start": 2, "end": 2}
"""What stands before the contour, and of how many numbers it is."""
BEFORE = sum(NUMBERS.values())
NOWHERE = np.full(2, np.nan)

Array = np.ndarray


class State(NamedTuple):
    """What is kept of the state after a push (table frame, metres, radians)."""

    numbers: Array
    """As `NUMBERS` has them, then the contour `(2 M,)`."""
    picture: bytes
    """The bottom view (JPEG)."""


def state_of(record: PushRecord, picture: bytes) -> State:
    """What is kept of a push; `picture` is its bottom view (JPEG)."""
    seen, path = record.view.seen, None if record.action is None else record.action.path
    start, end = (NOWHERE, NOWHERE) if path is None else (path.start, path.end)
    return State(np.concatenate([seen.c, [seen.theta], start, end, seen.contour.ravel()]), picture)


class StatesWriter:
    """Begins the file with one or more states, then appends."""

    def __init__(self, path: Path, fixed: Mapping[str, Any], first: Sequence[State]) -> None:
        """Replace the file; `fixed` are the arrays that stay the same, `first` the states so far."""
        self._numbers = len(first[0].numbers)
        same = {name: np.asarray(value, float).tolist() for name, value in fixed.items()}
        head = json.dumps({"M": (self._numbers - BEFORE) // 2, "fixed": same})
        with replacing(path) as temporary, temporary.open("wb") as file:
            file.write(block(head.encode()))
            file.writelines(map(self._bytes, first))
            synced(file)
        self._file = to_append(path)

    def append(self, state: State) -> None:
        """Append a state, whole or not at all. It is not forced to the disk: a state can be made again.

        Raises:
            OSError: no room for it.
        """
        append(self._file, self._bytes(state), sync=False)

    def close(self) -> None:
        """Release the file."""
        self._file.close()

    def _bytes(self, state: State) -> bytes:
        assert len(state.numbers) == self._numbers, "as many contour points as at first"
        return block(state.numbers.astype("<f8").tobytes() + state.picture)


class States:
    """A file read back, state by state: never more than one is in memory."""

    def __init__(self, path: Path, limited: bool = True) -> None:
        """Read what stays the same.

        Args:
            path: the file.
            limited: whether a file that is too large is refused; what this process wrote is not.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is damaged from its beginning; the message is one line.
        """
        self.path, self._most = path, FILE_BYTES if limited else 2**62
        self._count = COUNT if limited else None
        with open_file(path, self._most) as file:
            try:
                head = json.loads(next(blocks(file)))
                self.points = int(head["M"])
                self.fixed: dict[str, Array] = {name: np.array(v, float) for name, v in head["fixed"].items()}
            except HEADLESS:
                raise ValueError(f"{path}: damaged, or not written by a run") from None
        if self.points not in POINTS:
            raise ValueError(f"{path}: damaged, or not written by a run (M = {self.points})")

    def __iter__(self) -> Iterator[State]:
        """The states from k = 0 to the last one that is whole."""
        size = 8 * (BEFORE + 2 * self.points)
        with open_file(self.path, self._most) as file:
            for data in islice(blocks(file), 1, None if self._count is None else 1 + self._count):
                if len(data) < size:
                    return
                yield State(np.frombuffer(data[:size], "<f8"), data[size:])
