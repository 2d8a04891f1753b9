"""Memory and cost of recording over 2,000 pushes, and what it takes to look at such a run afterwards.

`python -m benchmarks.long_run` prints a table and draws docs/pictures/long_run.png. Each run, and each verb,
has a process of its own, so that its memory is its own.
"""

import multiprocessing
import os
import resource
import subprocess
import sys
import tempfile
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from deformpush.push_record import PushRecord

PUSHES = int(os.environ.get("PUSHES", "2000"))
FIRST, EARLY = 200, 100
"""Memory counts from this push on; the cost at this one is what later ones are held against."""
WINDOW = 50
"""Pushes to each side over which a cost is taken, as a median: the machine does other things too."""
CASES = {"random": ["optimizer=random"], "abo": ["optimizer=abo"]}
SETTINGS = ["world=toy", "robot=tool", "record=full", "object.d=[0.001,0.004]", "task.stop.position_m=1e-9"]
"""Short pushes, so that 2,000 of them leave the object in the picture."""
VERBS = {
    "compare": ["--out", "{scratch}/compare"],
    "report": ["--out", "{scratch}/report.html"],
    "video": ["--out", "{scratch}/video.mp4", "--seconds", "0.1"],
}
PICTURE = Path(__file__).parents[1] / "docs" / "pictures" / "long_run.png"


@dataclass(frozen=True)
class Measured:
    """A run, a value for each push."""

    memory: np.ndarray
    """Resident memory after push k (MB)."""
    record: np.ndarray
    """Time to record push k, all included (ms)."""
    peak: float
    """Most memory the process ever had (MB)."""
    close_s: float
    """Time to close the files (s)."""

    def cost(self, k: int) -> float:
        """Median of the time to record around push k (ms)."""
        return float(np.median(self.record[max(0, k - WINDOW) : k + WINDOW]))

    @property
    def growth(self) -> float:
        """Of the memory from push `FIRST` on (MB)."""
        return float(self.memory[-WINDOW:].max() - self.memory[FIRST - 1])


def main() -> None:
    """Measure, print and draw."""
    spawn = multiprocessing.get_context("spawn")
    found = {}
    with tempfile.TemporaryDirectory() as scratch:
        for name, settings in CASES.items():
            with spawn.Pool(1) as pool:
                found[name] = pool.apply(measured, ([*SETTINGS, *settings], Path(scratch, name)))
            told(name, found[name], Path(scratch, name))
        looked_at(Path(scratch, "random"), scratch)
    draw(found)


def measured(settings: list[str], folder: Path, pushes: int = PUSHES) -> Measured:
    """Make a run in this process and watch it."""
    from deformpush import loop
    from deformpush.config.compose import compose
    from deformpush.experiment.assemble import begin, build_cell, build_optimizer, describe
    from deformpush.experiment.recorder import Recorder
    from deformpush.experiment.setup import read
    from deformpush.record.folder import RunFolder
    from deformpush.study import run_figure

    setup = read(compose([*settings, f"max_pushes={pushes}"]))
    memory, seconds = [], []
    optimizer, cell = build_optimizer(setup), build_cell(setup)
    with closing(cell.world), Recorder(RunFolder.create(folder, setup.yaml), setup.record) as recorder:
        episode = begin(setup, cell, optimizer)

        def recorded(record: PushRecord) -> None:
            began = perf_counter()
            recorder(record)
            seconds.append(perf_counter() - began)
            memory.append(resident_mb())

        recorder.open(describe(setup, episode), episode.record, optimizer.state)
        ending = loop.run(episode, setup.record.maps, [recorded])
        began = perf_counter()
        recorder.close(ending.status, ending.reason)
        run_figure.draw(recorder.folder)
        close_s = perf_counter() - began
    assert ending.status == "budget", ending
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return Measured(np.array(memory), 1e3 * np.array(seconds), peak, close_s)


def resident_mb() -> float:
    """Memory of this process that is in use now (MB)."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


def told(name: str, run: Measured, folder: Path) -> None:
    """Print what was measured of a run."""
    last, files = len(run.record), sorted(folder.glob("*.*"))
    print(f"{name}: {last} pushes")
    print(f"  memory at push {FIRST}, {last} (MB)      {run.memory[FIRST - 1]:8.1f} {run.memory[-1]:8.1f}")
    print(f"  growth from push {FIRST} on (MB)       {run.growth:8.1f}      at most 20")
    print(f"  recording at push {EARLY}, {last} (ms)   {run.cost(EARLY):8.1f} {run.cost(last):8.1f}")
    print(f"  ratio                            {run.cost(last) / run.cost(EARLY):8.2f}      at most 1.5")
    print(f"  closing, with the figure (s, MB) {run.close_s:8.1f} {run.peak:8.1f}")
    sizes = ", ".join(
        f"{file.name} {file.stat().st_size / 1e6:.1f}" for file in files if file.stat().st_size > 1e5
    )
    print(f"  files (MB): {sizes}", flush=True)


def looked_at(folder: Path, scratch: str) -> None:
    """Print what the verbs need for a run: seconds, and most memory."""
    for verb, words in VERBS.items():
        line = [verb, str(folder), *(word.format(scratch=scratch) for word in words)]
        began = perf_counter()
        with subprocess.Popen(
            [sys.executable, "-m", "deformpush", *line], stdout=subprocess.DEVNULL
        ) as process:
            _, code, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(code)
        assert process.returncode == 0, verb
        print(f"{verb:<12}{perf_counter() - began:8.1f} s {usage.ru_maxrss / 1e3:8.0f} MB", flush=True)


def draw(found: dict[str, Measured]) -> None:
    """Memory above, cost below, over k."""
    import matplotlib
    from matplotlib.figure import Figure

    from deformpush.record import palette
    from deformpush.study.run_figure import DPI, STYLE, WIDTH

    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        for (name, run), colour in zip(found.items(), palette.RUNS, strict=False):
            k = np.arange(1, len(run.memory) + 1)
            above.plot(k, run.memory, color=palette.unit(colour), label=f"optimizer={name}")
            costs = [run.cost(at) for at in k]
            below.plot(
                k, run.record, ".", color=palette.unit(palette.lighter(colour)), markersize=1, zorder=1
            )
            below.plot(k, costs, color=palette.unit(colour), zorder=2)
        above.set(ylabel="resident memory (MB)", ylim=(0, None))
        most = max(float(np.quantile(run.record, 0.98)) for run in found.values())
        below.set(xlabel="push k", ylabel="recording a push (ms)", ylim=(0, most), xlim=(0, None))
        below.set_title(f"dots: each push; lines: median over {2 * WINDOW} pushes", loc="left")
        above.legend(loc="lower right")
        figure.savefig(PICTURE, dpi=DPI)
    print(f"written: {PICTURE}")


if __name__ == "__main__":
    main()
