"""Memory, recording and decisions over 2,000 pushes, and what it takes to look at such a run afterwards.

`python -m benchmarks.long_run` prints a table and draws docs/pictures/long_run.png. Each run, and each verb,
has a process of its own, so that its memory is its own. Costs are processor time, since the machine may do
other things too.
"""

import multiprocessing
import os
import resource
import tempfile
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time, thread_time
from typing import Any

import numpy as np

from benchmarks.many_runs import spent
from deformpush.push_record import PushRecord

PUSHES = int(os.environ.get("PUSHES", "2000"))
FIRST, EARLY = 200, 100
"""Memory counts from this push on; the cost at this one is what later ones are held against."""
GROWTH_MB, RATIO, DECISION_S = 20.0, 1.5, 1.0
"""What is allowed: growth of memory from push 200 on, cost of recording against push 100, a decision."""
WINDOW = 50
"""Pushes to each side over which a cost is taken, as a median."""
CASES = ("random", "abo", "abo_motion")
"""Optimizers: one without a model, and one for each model."""
SETTINGS = ["world=toy", "robot=tool", "record=full", "object.d=[0.001,0.004]", "task.stop.position_m=1e-9"]
"""Short pushes, so that 2,000 of them leave the object in the picture."""
VERBS = {
    "compare": ["--out", "{scratch}/compare"],
    "report": ["--out", "{scratch}/report.html"],
    "video": ["--out", "{scratch}/video.mp4", "--seconds", "0.1"],
}
PICTURE = Path(__file__).parents[1] / "docs" / "pictures" / "long_run.png"


def around(values: np.ndarray, k: int) -> float:
    """Median of a value over the pushes around push k."""
    return float(np.median(values[max(0, k - WINDOW) : k + WINDOW]))


@dataclass(frozen=True)
class Measured:
    """A run, a value for each push."""

    memory: np.ndarray
    """Resident memory after push k (MB)."""
    record: np.ndarray
    """Processor time to record push k (ms)."""
    waited: np.ndarray
    """How long the run waited for that (ms)."""
    decide: np.ndarray
    """Processor time to ask and tell the optimizer before and after push k (s)."""
    peak: float
    """Most memory the process ever had (MB)."""
    close_s: float
    """Time to close the files (s)."""

    @property
    def growth(self) -> float:
        """Of the memory from push `FIRST` on (MB)."""
        return float(self.memory[-WINDOW:].max() - self.memory[FIRST - 1])


def main() -> None:
    """Measure, print and draw."""
    spawn = multiprocessing.get_context("spawn")
    found = {}
    with tempfile.TemporaryDirectory() as scratch:
        for name in CASES:
            with spawn.Pool(1) as pool:
                found[name] = pool.apply(measured, (name, Path(scratch, name)))
            told(name, found[name], Path(scratch, name))
        for name in CASES:
            looked_at(Path(scratch, name), Path(scratch, f"{name} seen"))
    draw(found)


def measured(optimizer_name: str, folder: Path, pushes: int = PUSHES) -> Measured:
    """Make a run in this process and watch it."""
    from deformpush import loop
    from deformpush.config.compose import compose
    from deformpush.experiment.assemble import begin, build_cell, build_optimizer, describe
    from deformpush.experiment.recorder import Recorder
    from deformpush.experiment.setup import read
    from deformpush.record.folder import RunFolder
    from deformpush.study import run_figure

    setup = read(compose([*SETTINGS, f"optimizer={optimizer_name}", f"max_pushes={pushes}"]))
    memory, record, waited, decide = np.zeros((4, pushes))
    optimizer, cell = build_optimizer(setup), build_cell(setup)
    told_k = 0

    def counted(function: Callable[..., Any]) -> Callable[..., Any]:
        def called(*given: Any) -> Any:
            began = process_time()
            answer = function(*given)
            decide[told_k] += process_time() - began
            return answer

        return called

    for method in ("ask", "tell"):
        setattr(optimizer, method, counted(getattr(optimizer, method)))
    with closing(cell.world), Recorder(RunFolder.create(folder, setup.yaml), setup.record) as recorder:
        episode = begin(setup, cell, optimizer)

        def recorded(push: PushRecord) -> None:
            nonlocal told_k
            began, began_thread = perf_counter(), thread_time()
            recorder(push)
            waited[told_k] = 1e3 * (perf_counter() - began)
            record[told_k] = 1e3 * (thread_time() - began_thread)
            memory[told_k] = resident_mb()
            told_k = push.k

        recorder.open(describe(setup, episode), episode.record, optimizer.state)
        ending = loop.run(episode, setup.record.maps, [recorded])
        began = perf_counter()
        recorder.close(ending.status, ending.reason)
        run_figure.draw(recorder.folder)
        close_s = perf_counter() - began
    assert ending.status == "budget", ending
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return Measured(memory, record, waited, decide, peak, close_s)


def resident_mb() -> float:
    """Memory of this process that is in use now (MB)."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


def told(name: str, run: Measured, folder: Path) -> None:
    """Print what was measured of a run."""
    last = len(run.record)

    def line(what: str, *values: float, most: str = "") -> None:
        print(f"  {what:<38}{''.join(f'{value:10.3g}' for value in values):<22}{most}".rstrip(), flush=True)

    def costs(values: np.ndarray) -> tuple[float, float]:
        return around(values, EARLY), around(values, last)

    print(f"optimizer={name}: {last} pushes")
    line(f"memory at push {FIRST}, {last} (MB)", run.memory[FIRST - 1], run.memory[-1])
    line(f"growth from push {FIRST} on (MB)", run.growth, most=f"at most {GROWTH_MB:g}")
    early, late = costs(run.record)
    line(f"recording at push {EARLY}, {last} (ms)", early, late)
    line("ratio", late / early, most=f"at most {RATIO:g}")
    line("waited for it (ms)", *costs(run.waited))
    line(f"deciding at push {EARLY}, {last} (s)", *costs(run.decide))
    line(f"slowest of the last {WINDOW} (s)", run.decide[-WINDOW:].max(), most=f"at most {DECISION_S:g}")
    line("closing, with the figure (s)", run.close_s)
    line("most memory (MB)", run.peak)
    for file in sorted(folder.glob("*.*")):
        if (size := file.stat().st_size / 1e6) > 0.1:
            line(f"{file.name} (MB)", size)


def looked_at(folder: Path, out: Path) -> None:
    """Print what the verbs need for a run."""
    for verb, words in VERBS.items():
        took = spent([verb, str(folder), *(word.format(scratch=out) for word in words)])
        print(f"{folder.name:<11} {verb:<8}{took.seconds:8.1f} s {took.peak_mb:8.0f} MB", flush=True)


def draw(found: dict[str, Measured]) -> None:
    """Memory, recording and decisions over k, below each other, with what is allowed."""
    import matplotlib
    from matplotlib.figure import Figure

    from deformpush.record import palette
    from deformpush.study.run_figure import DASHES, DPI, STYLE, WIDTH

    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 5.2), layout="constrained")
        memory, record, decide = axes = figure.subplots(3, 1, sharex=True)
        for (name, run), colour in zip(found.items(), palette.RUNS, strict=False):
            k = np.arange(1, len(run.memory) + 1)
            line, dots = palette.unit(colour), palette.unit(palette.lighter(colour))
            memory.plot(
                k, run.memory - run.memory[FIRST - 1], color=line, linewidth=0.8, label=f"optimizer={name}"
            )
            for axis, values in ((record, run.record), (decide, run.decide)):
                axis.plot(k, values, ".", color=dots, markersize=1.5, markeredgewidth=0, zorder=1)
                axis.plot(k, [around(values, at) for at in range(1, len(values) + 1)], color=line, zorder=3)
        highest = max(float(np.quantile(run.record, 0.98)) for run in found.values())
        memory.set(ylabel=f"resident memory,\nless that at push {FIRST} (MB)", ylim=(-10, 25))
        record.set(ylabel="recording a push (ms)", ylim=(0, 1.2 * highest))
        decide.set(ylabel="deciding on a push (s)", yscale="log", ylim=(1e-4, 3), xlabel="push k")
        for axis, most in ((memory, GROWTH_MB), (decide, DECISION_S)):
            axis.axhline(most, color=palette.unit(palette.STOP), linestyle=DASHES, linewidth=0.9)
            place = {
                "xytext": (-2, 2),
                "textcoords": "offset points",
                "ha": "right",
                "size": 7,
                "color": "0.35",
            }
            axis.annotate("allowed", (1, most), xycoords=("axes fraction", "data"), **place)
        for axis in axes:
            axis.spines["right"].set_visible(False)
        record.set_xlim(0, max(len(run.memory) for run in found.values()))
        figure.legend(*memory.get_legend_handles_labels(), loc="outside upper left", ncols=len(found))
        figure.supxlabel(
            f"processor time; dots: each push, lines: median over {2 * WINDOW} pushes", size=6, color="0.4"
        )
        figure.align_ylabels(list(axes))
        figure.savefig(PICTURE, dpi=DPI)
    print(f"written: {PICTURE}")


if __name__ == "__main__":
    main()
