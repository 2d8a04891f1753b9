"""A sweep of many finished runs, and what it takes to look at it: `python -m benchmarks.many_runs [RUNS]`.

One short toy run is made and laid out `RUNS` times as a sweep: `VARIANTS` settings with as many seeds each.
Each verb then has a process of its own; what counts is its processor time, since the machine may do other
things too.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path
from typing import NamedTuple

import numpy as np

RUNS = 10_000
VARIANTS = 20
"""Different values of `acq.w`."""
PUSHES = 20
MADE = ["world=toy", "robot=tool", "record=off", "record.figures=false", f"max_pushes={PUSHES}"]
VERBS: dict[str, tuple[list[str], float | None]] = {
    "status": ([], 5.0),
    "compare": (["--out", "{scratch}"], 60.0),
    "report": (["--out", "{scratch}/report.html"], None),
}
"""What each is given beside the sweep, and at most how many seconds it may take."""
ROOT = Path(__file__).resolve().parents[1]


class Spent(NamedTuple):
    """What a process took."""

    seconds: float
    """Of the processor."""
    peak_mb: float
    """Most memory it ever had."""


def main() -> None:
    """Lay out, measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="?", type=int, default=RUNS)
    runs = parser.parse_args().runs
    with tempfile.TemporaryDirectory() as scratch:
        sweep = lay_out(Path(scratch, "sweep"), runs)
        print(f"{runs} finished runs, {VARIANTS} variants")
        for verb, (words, most) in VERBS.items():
            took = spent([verb, str(sweep), *(word.format(scratch=scratch) for word in words)])
            target = f"      at most {most:g} s" if most else ""
            print(f"{verb:<10}{took.seconds:8.1f} s {took.peak_mb:8.0f} MB{target}", flush=True)


def lay_out(root: Path, runs: int) -> Path:
    """Make the folder of a sweep of finished runs, which differ in acq.w and seed, errors and times.

    Tables are files of their own, as no two runs have the same; what no verb asked of here reads is linked.
    """
    from deformpush.config.compose import compose
    from deformpush.experiment.run import make_run
    from deformpush.experiment.setup import read
    from deformpush.experiment.sweep import manifest
    from deformpush.experiment.sweep.manifest import Job

    made, rng, jobs = root / ".made", np.random.default_rng(0), []
    with redirect_stdout(sys.stderr):
        make_run(read(compose(MADE)), made)
    config, table = (made / "config.yaml").read_text(), (made / "pushes.csv").read_text()
    summary = json.loads((made / "summary.json").read_text())
    for i in range(runs):
        seed, variant = divmod(i, VARIANTS)
        job = Job(f"acq.w={variant},seed={seed}", [f"acq.w={variant}", f"seed={seed}"])
        jobs.append(job)
        run = root / job.name
        run.mkdir()
        text = re.sub(r"(?m)^seed: \d+$", f"seed: {seed}", config)
        (run / "config.yaml").write_text(
            re.sub(r"(?m)^(acq:\n(?: .*\n)*?  w:) .*$", rf"\g<1> {variant}", text)
        )
        end = {**summary, "seed": seed, "wall_s": float(rng.uniform(1, 3)), "e_T": float(rng.uniform())}
        (run / "summary.json").write_text(json.dumps(end, indent=1))
        (run / "pushes.csv").write_text(_shaken(table, rng))
        for name in ("provenance.json", "contours.npz", "views.npz", ".lock"):
            os.link(made / name, run / name)
    manifest.write(root, jobs)
    return root


def _shaken(table: str, rng: np.random.Generator) -> str:
    """pushes.csv with other errors: each column of them times a number of its own."""
    from deformpush.task import ERROR_COLUMNS

    head, *lines = table.splitlines()
    names = head.split(",")
    factors = {names.index(name): float(rng.uniform(0.5, 1.5)) for name in ERROR_COLUMNS if name in names}
    rows = [line.split(",") for line in lines]
    for row in rows:
        for i, factor in factors.items():
            row[i] = repr(float(row[i]) * factor)
    return "\n".join([head, *(",".join(row) for row in rows), ""])


def spent(words: list[str]) -> Spent:
    """Carry out a command of this project and see what it took."""
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    line = [sys.executable, "-m", "deformpush", *words]
    environment = {**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1"}
    with subprocess.Popen(line, stdout=subprocess.DEVNULL, env=environment) as process:
        _, code, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(code)
    if process.returncode:
        raise SystemExit(f"{' '.join(words)}: exit code {process.returncode}")
    return Spent(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e3)


if __name__ == "__main__":
    main()
