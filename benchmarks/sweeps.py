"""Many runs: `python -m benchmarks.sweeps [PART ...]`, on a machine that does nothing else.

processes   40 short runs by two processes against one, start-up counted
composing   how long a sweep of 100 runs composes before the first begins
engine      the same for Bullet alone: what the machine allows two processes to gain
resume      taking up a run of 40 pushes against making the pushes with the bare simulator
"""

import argparse
import contextlib
import io
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.__main__ import row

SHORT = ["robot=tool", "record=off", "record.figures=false", "optimizer=random", "max_pushes=3"]
TOY = ["world=toy", *SHORT]
RUNS = 40
PUSHES = 40
ALONE = 40


def main() -> None:
    """Measure what is asked for, or all."""
    parts: dict[str, Callable[[Path], None]] = {
        "processes": processes,
        "composing": composing,
        "engine": engine,
        "resume": resuming,
    }
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(parts))
    asked = parser.parse_args().parts or list(parts)
    if unknown := set(asked) - set(parts):
        parser.error(f"{', '.join(sorted(unknown))}: no such part; parts: {', '.join(parts)}")
    print(f"{'figure':<52}{'measured':>10}{'target':>10}")
    for name in asked:
        with tempfile.TemporaryDirectory() as scratch:
            parts[name](Path(scratch))


def command(folder: Path, *words: str) -> float:
    """Seconds that a command of this project takes from start to exit, in `folder`."""
    began = perf_counter()
    line = [sys.executable, "-m", "deformpush", *words]
    paths = os.pathsep.join([str(Path(__file__).resolve().parent.parent), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        line, cwd=folder, env={**os.environ, "PYTHONPATH": paths}, stdout=subprocess.DEVNULL, check=False
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(words)}: exit code {done.returncode}")
    return perf_counter() - began


def processes(scratch: Path) -> None:
    """The same runs in one process, one after the other, and in two."""
    times = []
    for n in (1, 2):
        launcher = ["hydra/launcher=processes", f"hydra.launcher.n_jobs={n}", f"hydra.sweep.dir=by-{n}"]
        times.append(command(scratch, "-m", *SHORT, f"seed=range({RUNS})", *launcher))
        row(f"{RUNS} runs of 3 pushes by {n} process{'es' * (n > 1)} (s)", times[-1], float("nan"))
    row("runs per hour, two processes over one (-)", times[0] / times[1], 1.9)


def composing(scratch: Path) -> None:
    """A sweep whose runs take no time at all: what is left is Hydra."""
    from deformpush import __main__
    from deformpush.experiment.sweep import run_or_resume as job

    first: list[float] = []
    job.read = lambda cfg: cfg  # type: ignore[assignment, return-value]
    job.make_run = lambda *_: first.append(perf_counter())  # type: ignore[assignment, func-returns-value]
    argv, here = sys.argv, Path.cwd()
    os.chdir(scratch)
    sys.argv = ["deformpush", "-m", *TOY, "seed=range(100)"]
    began = perf_counter()
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
            __main__.main()
    finally:
        sys.argv = argv
        os.chdir(here)
    row("sweep of 100 runs, until the first begins (s)", first[0] - began, float("nan"))
    row("the same, Hydra's share of each run after that (s)", (first[-1] - first[0]) / 99, float("nan"))


def engine(_: Path) -> None:
    """Worlds that are ready before the clock starts, each pushed in a process of its own."""
    times = []
    for n in (1, 2):
        with ProcessPoolExecutor(n) as pool:
            list(pool.map(stepped, [1] * n))
            began = perf_counter()
            list(pool.map(stepped, [ALONE // n] * n))
            times.append(perf_counter() - began)
    row(f"{ALONE} pushes in Bullet alone, two processes over one (-)", times[0] / times[1], float("nan"))


def stepped(pushes: int) -> None:
    """Push rect forth and back, 20 mm each time, and do nothing else."""
    from deformpush.cell.push import ToolPath

    world = _world()
    for k in range(pushes):
        direction = np.array([0.0, 1.0 - 2.0 * (k % 2)])
        reach = (world.nodes() @ [0.0, direction[1], 0.0]).min() - world.tool_radius
        contact = np.array([world.nodes()[:, 0].mean(), reach * direction[1]])
        world.push(ToolPath(contact - 0.02 * direction, direction, 0.02, 0.02))


@cache
def _world() -> Any:
    """The world of this process."""
    from deformpush.config.compose import compose
    from deformpush.experiment.assemble import build_cell
    from deformpush.experiment.setup import read

    return build_cell(read(compose(["robot=tool", "record=off"]))).world


def resuming(scratch: Path) -> None:
    """A run that was killed after its last push: all must be made again, nothing is left to do."""
    from deformpush.cell.push import ToolPath
    from deformpush.config.compose import compose
    from deformpush.experiment.assemble import begin, build_cell, build_optimizer
    from deformpush.experiment.console import Verbosity
    from deformpush.experiment.run import make_run, resume
    from deformpush.experiment.setup import read
    from deformpush.record import unfinished
    from deformpush.record.folder import RunFolder

    rect = ["robot=tool", "record=off", "record.figures=false", f"max_pushes={PUSHES}"]
    setup = read(compose([*rect, "task.stop.position_m=1e-9"]))
    folder = RunFolder(scratch / "run")
    make_run(setup, folder.path, Verbosity.BAR_ONLY)
    folder.summary.unlink()
    left = unfinished.read(folder)

    paths: list[ToolPath] = []
    cell = build_cell(setup)
    make = cell.world.push
    cell.world.push = lambda path: paths.append(path) or make(path)  # type: ignore[func-returns-value, method-assign]
    episode = begin(setup, cell, build_optimizer(setup))
    for k in range(1, left.pushes + 1):
        episode.repeat(left.proposal(k))
    cell.world.close()

    bare, taken_up = [], []
    for _ in range(3):
        began = perf_counter()
        cell = build_cell(setup)
        for path in paths:
            cell.world.push(path)
        cell.world.close()
        bare.append(perf_counter() - began)

        folder.summary.unlink(missing_ok=True)
        began = perf_counter()
        resume(folder.path, Verbosity.BAR_ONLY)
        taken_up.append(perf_counter() - began)
    row(f"the bare simulator, {PUSHES} pushes, median of 3 (s)", float(np.median(bare)), float("nan"))
    row("resume, median of 3 (s)", float(np.median(taken_up)), float("nan"))
    row("resume over the bare simulator (-)", float(np.median(taken_up) / np.median(bare)), 1.0)


if __name__ == "__main__":
    main()
