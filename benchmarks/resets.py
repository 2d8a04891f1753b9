"""Simulators built, used and closed in one process: `python -m benchmarks.resets [TIMES]`.

A sweep with Hydra's basic launcher makes all its runs in one process, so whatever a simulator leaves behind
adds up.
"""

import argparse
import multiprocessing
import os
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.long_run import resident_mb

TIMES = 300
EARLY = 50
"""What is there after so many is held against what is there in the end."""
ROBOTS = ("tool", "kuka_iiwa")
PUSH = np.array([0.5, 0.02])
"""kappa, d (m)."""


class Left(NamedTuple):
    """What a process has after a simulator was closed."""

    memory: float
    """Resident (MB)."""
    files: int
    """Open."""
    threads: int


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("times", nargs="?", type=int, default=TIMES)
    times = parser.parse_args().times
    spawn = multiprocessing.get_context("spawn")
    for robot in ROBOTS:
        with spawn.Pool(1) as pool:
            left = pool.apply(resets, ([f"robot={robot}"], times))
        print(f"robot={robot}: {times} simulators, a push in each")
        for n in sorted({min(n, times) for n in (1, EARLY, times // 2, times)}):
            now = left[n - 1]
            print(
                f"  after {n:>4}: {now.memory:6.1f} MB, {now.files} files, {now.threads} threads", flush=True
            )


def resets(settings: list[str], times: int) -> list[Left]:
    """Build a world, look, push, look and close it, again and again; what is left after each."""
    from deformpush.config.compose import compose
    from deformpush.experiment.assemble import build_cell
    from deformpush.experiment.setup import read

    setup, left = read(compose(settings)), []
    for _ in range(times):
        cell = build_cell(setup)
        with closing(cell.world):
            seen = cell.look(None)[0].seen
            cell.world.push(cell.plan(PUSH, seen))
            cell.look(seen)
        left.append(
            Left(
                resident_mb(), len(os.listdir("/proc/self/fd")), len(list(Path("/proc/self/task").iterdir()))
            )
        )
    return left


if __name__ == "__main__":
    main()
