"""The pushing table: many seeds of one or more scenarios, run side by side, and what became of them.

    python -m benchmarks.pushing --folder runs/table --scenarios object=rect object=meat --seeds 0-19

Every run is the ordinary command. The optimizer does not know the stop values, so a run with `stop=paper`
is the run with `stop=strict`, ended earlier: a strict run answers for both, and `--stop paper` asks for
less. Runs that exist are kept, so the command can be stopped and started again.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from deformpush.record.folder import RunFolder
from deformpush.record.status import run_status
from deformpush.task import TERMS

STOPS = {
    "paper": {"position_m": 0.02, "angle_deg": 7.0},
    "strict": {"position_m": 0.01, "angle_deg": 5.0},
}
"""What the options of the group `stop` set; the other stop values are the object's."""


def main() -> None:
    """Run what is missing and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", type=Path, default=Path("runs/table"))
    parser.add_argument(
        "--scenarios", nargs="+", default=["object=rect", "object=meat"], help="comma between overrides"
    )
    parser.add_argument("--seeds", default="0-19", help="first-last")
    parser.add_argument("--stop", choices=STOPS, default="strict", help="strict answers for both")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--table-only", action="store_true", help="only read what is there")
    given = parser.parse_args()
    seeds = seeds_of(given.seeds)
    jobs = [(scenario, seed) for seed in seeds for scenario in given.scenarios]
    if not given.table_only:
        run_all(given.folder, jobs, given.stop, given.processes)
    for scenario in given.scenarios:
        rows = [row for seed in seeds if (row := result(given.folder, scenario, seed, given.stop))]
        if rows:
            print(
                text(
                    scenario, pd.DataFrame(rows), ["paper", "strict"] if given.stop == "strict" else ["paper"]
                )
            )


def seeds_of(text: str) -> range:
    """The seeds that "first-last", or one number, means."""
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def run_all(
    folder: Path,
    jobs: list[tuple[str, int]],
    stop: str,
    processes: int,
    beside: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> None:
    """Make all runs (scenario, seed) that are missing, side by side.

    Args:
        folder: for the runs, each in a folder named by its scenario.
        jobs: scenarios are overrides with commas between.
        stop: option of the group stop.
        processes: so many runs at once.
        beside: overrides that a part of the scenario stands for, where it is too long to name a folder.
    """
    from tqdm import tqdm

    with ThreadPoolExecutor(processes) as pool:
        runs = pool.map(lambda job: run(folder, *job, stop, beside), jobs)
        for _ in tqdm(runs, total=len(jobs), desc="runs"):
            pass


def finished(folder: Path, scenario: str, seed: int, stop: str) -> Path | None:
    """Folder of the finished run that answers for this stop rule, the strict one first; None without one."""
    places = [folder / f"{scenario},stop={name},seed={seed}" for name in dict.fromkeys(("strict", stop))]
    ended = ("done", "failed")  # one that was interrupted answers for nothing: it is continued
    return next((place for place in places if run_status(RunFolder(place)).state in ended), None)


def run(
    folder: Path,
    scenario: str,
    seed: int,
    stop: str,
    beside: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> None:
    """Make one run unless a finished one answers for it; one that was stopped is continued."""
    if finished(folder, scenario, seed, stop):
        return
    target = folder / f"{scenario},stop={stop},seed={seed}"
    overrides = [text for part in scenario.split(",") for text in beside.get(part, [part])]
    command = [sys.executable, "-m", "deformpush", "record=light", *overrides]
    command += [f"seed={seed}", f"stop={stop}", f"hydra.run.dir='{target}'"]
    if (target / "config.yaml").exists():
        command = [sys.executable, "-m", "deformpush", "resume", str(target)]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    subprocess.run(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False
    )


def result(folder: Path, scenario: str, seed: int, stop: str) -> dict[str, object] | None:
    """One row of the table: when each stop rule was met (nan: never), and how the run ended."""
    target = finished(folder, scenario, seed, stop)
    if target is None:
        return None
    summary = json.loads((target / "summary.json").read_text())
    pushes = pd.read_csv(target / "pushes.csv")
    own = stop_values(target / "config.yaml")
    row: dict[str, object] = {"seed": seed}
    for name, changed in STOPS.items():
        stops = own | changed
        # An error that is not there, as that of the angle of a round object, is met.
        met = [~(pushes[term.column].abs() > stops[term.stop] * term.stop_scale) for term in TERMS]
        row[name] = float(pushes.k[np.logical_and.reduce(met)].min())
    failed = summary["status"] == "failed"
    row |= {term.name: abs(pushes[term.column].iloc[-1]) * term.scale for term in TERMS}
    return row | {
        "pushes": summary["pushes"],
        "failure": summary["reason"] if failed else "",
        "wall_s": summary["wall_s"],
        "step_s": summary["step_s"],
        "decide_s": summary["decide_s"],
        "calibration": summary.get("calibration"),
    }


def stop_values(config: Path) -> dict[str, float]:
    """The stop values that a run was made with, as they are set."""
    import yaml

    found = yaml.safe_load(config.read_text())["task"]["stop"]
    return {term.stop: float(found[term.stop]) for term in TERMS}


def text(scenario: str, rows: pd.DataFrame, stops: list[str]) -> str:
    """Markdown: one line a stop rule, then one line a seed."""
    lines = [f"\n### `{scenario}`, {len(rows)} seeds\n"]
    lines += [
        "| stop | arrived | 95 % (Wilson) | median, arrived | Kaplan-Meier median, all | range |",
        "|---|---|---|---|---|---|",
    ]
    for name in stops:
        arrived = rows[name].dropna()
        low, high = wilson(len(arrived), len(rows))
        lines.append(
            f"| {name} | {len(arrived)} of {len(rows)} | {low:.0%} to {high:.0%} | "
            f"{number(arrived.median())} | "
            f"{number(kaplan_meier_median(rows[name], rows.pushes))} | "
            f"{number(arrived.min())} to {number(arrived.max())} |"
        )
    to = [f"to `{name}`" for name in stops]
    errors = [f"{term.name} ({term.unit})" for term in TERMS]
    heads = ["seed", *to, "pushes made", *errors, "failure"]
    lines += ["", f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for r in rows.itertuples():
        arrivals = [number(getattr(r, name)) for name in stops]
        last = [*(f"{getattr(r, term.name):.{term.digits}f}" for term in TERMS), r.failure]
        lines.append(f"| {' | '.join([str(r.seed), *arrivals, str(r.pushes), *last])} |")
    return "\n".join(lines)


def number(value: float) -> str:
    """A count, or a dash for never."""
    return "-" if np.isnan(value) else f"{value:g}"


def wilson(hits: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """95 % interval of a rate (Wilson 1927)."""
    rate, spread = hits / n, z / n * np.sqrt(hits * (n - hits) / n + z**2 / 4)
    middle = rate + z**2 / (2 * n)
    scale = 1 + z**2 / n
    return max(0.0, (middle - spread) / scale), min(1.0, (middle + spread) / scale)


def kaplan_meier_median(arrived: pd.Series, made: pd.Series) -> float:
    """Push at which half of all runs have arrived; runs that never did are censored at their last push."""
    time, event = arrived.fillna(made).to_numpy(), arrived.notna().to_numpy()
    alive = 1.0
    for t in np.unique(time[event]):
        alive *= 1 - np.sum(event & (time == t)) / np.sum(time >= t)
        if alive <= 0.5:
            return float(t)
    return float("nan")


if __name__ == "__main__":
    main()
