"""Ways to harm a run from outside."""

import os
import random
import signal
import time
from collections.abc import Callable
from pathlib import Path

from deformpush.experiment.run import make_run
from deformpush.experiment.setup import Setup


def ended_by(sign: int, made: Setup, folder: Path, after_rows: int, delay_s: float) -> bool:
    """Make a run in a child process and send it a signal some time after a row; whether that was in time."""
    child = in_child(lambda: make_run(made, folder))
    table, patience = folder / "pushes.csv", time.monotonic() + 60
    while time.monotonic() < patience and os.waitpid(child, os.WNOHANG) == (0, 0):
        if table.exists() and table.read_bytes().count(b"\n") - 2 >= after_rows:
            time.sleep(delay_s)
            os.kill(child, sign)
            os.waitpid(child, 0)
            return not (folder / "summary.json").exists() or sign != signal.SIGKILL
        time.sleep(0.001)
    return False


def in_child(work: Callable[[], object]) -> int:
    """Start work in a copy of this process that says nothing; its process number."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            sink = os.open(os.devnull, os.O_WRONLY)
            os.dup2(sink, 1)
            os.dup2(sink, 2)
            work()
            code = 0
        finally:
            os._exit(code)
    return child


def moments(n: int, pushes: int, seed: int = 0) -> list[tuple[int, float]]:
    """Rows and delays (s) at which to strike: anywhere in a run of so many pushes."""
    rng = random.Random(seed)
    return [(rng.randrange(pushes), rng.uniform(0, 0.02)) for _ in range(n)]
