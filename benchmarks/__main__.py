"""Speed of the whole, as one table: `python -m benchmarks`. Studies have their own: `make bench-NAME`."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from benchmarks.startup import REPEATS, TARGET_S, seconds

PUSHES = 60


def main() -> None:
    """Measure start-up, one whole 60-push run of the default scene, and its parts."""
    print(f"{'figure':<52}{'measured':>10}{'target':>10}")
    for argv in (["--help"], ["--cfg", "job"]):
        row(f"{' '.join(argv)}, median (s)", seconds(argv)[REPEATS // 2], TARGET_S)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        wall = endless(folder)
        summary = json.loads((folder / "summary.json").read_text())
        size = (folder / "recording.rrd").stat().st_size / 1e6
        row(f"run of {summary['pushes']} pushes, start to exit (s)", wall, 60)
        row("the same over the time inside Bullet (-)", wall / summary["step_s"], 1.25)
        row("one decision at 50 to 60 samples, median (ms)", late_decision(folder), 60)
        row("recording, share of the run (%)", 100 * summary["record_s"] / wall, 5)
        row("recording.rrd (MB)", size, 10)
        folder = Path(scratch) / "motion"
        endless(folder, "optimizer=abo_motion", "world=toy", "robot=tool", "record=off")
        row("the same decision, optimizer=abo_motion (ms)", late_decision(folder), 150)


def endless(folder: Path, *settings: str) -> float:
    """Make a run whose stop cannot be met, so that it lasts for all its pushes; its seconds."""
    settings = (*settings, f"max_pushes={PUSHES}", "task.stop.position_m=1e-9", f"hydra.run.dir={folder}")
    began = perf_counter()
    subprocess.run([sys.executable, "-m", "deformpush", *settings], check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - began


def late_decision(folder: Path) -> float:
    """Median milliseconds of the last ten decisions."""
    lines = (folder / "pushes.csv").read_text().splitlines()
    column = lines[0].split(",").index("decide_s")
    return 1e3 * sorted(float(line.split(",")[column]) for line in lines[-10:])[5]


def row(name: str, value: float, target: float) -> None:
    """Print one line."""
    print(f"{name:<52}{value:>10.3g}{target:>10.3g}", flush=True)


if __name__ == "__main__":
    main()
