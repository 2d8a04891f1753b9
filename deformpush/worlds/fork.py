"""Trying something out in a copy of the whole process, engine and all, of which nothing stays.

PyBullet can save the state of rigid bodies only; a forked process has everything, exactly.
"""

import os
import pickle
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

import numpy as np

from deformpush.cell.push import ToolPath
from deformpush.cell.world import World

T = TypeVar("T")


def pictures_after(world: World, paths: Sequence[ToolPath]) -> list[np.ndarray | None]:
    """The picture after each push, made in a forked copy of the world; None where one fails."""

    def trial(path: ToolPath) -> np.ndarray:
        world.push(path)
        return world.picture()

    return branched([partial(trial, path) for path in paths], os.cpu_count() or 1)


def branched(jobs: Sequence[Callable[[], T]], processes: int) -> list[T | None]:
    """What each job returns in a forked copy of this process; None where it raised or died.

    Args:
        jobs: what to do there; results must pickle.
        processes: copies at work at the same time.
    """
    results: list[T | None] = []
    for i in range(0, len(jobs), processes):
        copies = [_fork(job) for job in jobs[i : i + processes]]
        results += [_collect(*copy) for copy in copies]
    return results


def _fork(job: Callable[[], T]) -> tuple[int, int]:
    """Start a copy; its process number and the end of the pipe to read from."""
    read, write = os.pipe()
    pid = os.fork()
    if pid:
        os.close(write)
        return pid, read
    # In the copy: whatever happens it must end here, without the parent's closing ceremonies.
    try:
        os.close(read)
        with os.fdopen(write, "wb") as pipe:
            pickle.dump(job(), pipe)
    except BaseException:
        os._exit(1)
    os._exit(0)


def _collect(pid: int, read: int) -> T | None:
    with os.fdopen(read, "rb") as pipe:
        data = pipe.read()
    _, status = os.waitpid(pid, 0)
    return pickle.loads(data) if status == 0 else None
