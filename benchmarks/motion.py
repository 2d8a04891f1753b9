"""The motion model against the paper's error model and the oracle: `python -m benchmarks.motion`.

Every scenario is an `experiment` with jittered start, goal and material and `stop=strict`, budget 80 pushes.
A model's runs that exist are kept, so the command can be stopped and started again, and `--only` makes the
runs of some methods first. The oracle tries some 56 pushes for real before each one it makes.
"""

import argparse
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.pushing import kaplan_meier_median, number, result, run_all, seeds_of

METHODS = {
    "motion": "optimizer=abo_motion",
    "error": "optimizer=abo",
    "oracle": "optimizer=oracle,record=off",
}
SCENARIOS = {
    "rect_straight": (7, 1.3),
    "rect_straight,robot=kuka_iiwa": (7, 1.3),
    "rect_turned": (7, 1.6),
    "rect_sideways": (7, 1.6),
    "meat_straight": (5, 1.3),
}
"""Scenario -> (distance over d_max, rounded up; median allowed as a multiple of it)."""


def main() -> None:
    """Run what is missing and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", type=Path, default=Path("runs/motion"))
    parser.add_argument("--seeds", default="0-19", help="first-last")
    parser.add_argument("--only", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument("--scenarios", nargs="+", choices=SCENARIOS, default=list(SCENARIOS))
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--world", default="bullet", help="option of the group world")
    parser.add_argument("--table-only", action="store_true", help="only read what is there")
    given = parser.parse_args()
    seeds = seeds_of(given.seeds)
    if not given.table_only:
        for method in given.only:
            jobs = [(run_of(name, method, given.world), seed) for seed in seeds for name in given.scenarios]
            # The oracle keeps all cores busy by itself.
            run_all(given.folder, jobs, "strict", 1 if method == "oracle" else given.processes)
    print(text(given.folder, given.scenarios, seeds, given.world))


def run_of(scenario: str, method: str, world: str) -> str:
    """Overrides, with commas between."""
    return f"experiment={scenario},{METHODS[method]}{in_world(world)}"


def in_world(world: str) -> str:
    """What to add to overrides so that a run is made in that world."""
    return "" if world == "bullet" else f",world={world}"


def text(folder: Path, scenarios: list[str], seeds: range, world: str) -> str:
    """Markdown: one line per scenario and method, then the pushes of every seed."""
    lines = [
        "| scenario | model | arrived | median, all (95 %) | worst | allowed | inside 95 % | decision |",
        "|---|---|---|---|---|---|---|---|",
    ]
    each = ["| scenario | model | pushes of seed " + f"{seeds[0]} to {seeds[-1]} |", "|---|---|---|"]
    for name in scenarios:
        bound, factor = SCENARIOS[name]
        for method in METHODS:
            rows = [result(folder, run_of(name, method, world), seed, "strict") for seed in seeds]
            made = pd.DataFrame([row for row in rows if row])
            if made.empty:
                continue
            low, high = bootstrap(made.strict, made.pushes)
            median = number(kaplan_meier_median(made.strict, made.pushes))
            allowed = f"{factor * bound:.1f}, worst {2.5 * bound:g}" if method == "motion" else ""
            inside = f"{made.calibration.astype(float).mean():.0%}" if method == "motion" else ""
            worst = number(made.strict.max()) if made.strict.notna().all() else "never"
            lines.append(
                f"| {name} | {method} | {made.strict.notna().sum()} of {len(made)} | "
                f"{median} ({number(low)} to {number(high)}) | {worst} | {allowed} | {inside} | "
                f"{1e3 * (made.decide_s / made.pushes).median():.0f} ms |"
            )
            each.append(f"| {name} | {method} | {', '.join(arrival(row) for row in rows)} |")
    return "\n".join([*lines, "", *each])


def arrival(row: dict[str, Any] | None) -> str:
    """Pushes to the goal; `>` and the pushes made where it was not reached, `?` where there is no run."""
    if row is None:
        return "?"
    return f">{row['pushes']}" if math.isnan(row["strict"]) else f"{row['strict']:g}"


def bootstrap(arrived: pd.Series, made: pd.Series, draws: int = 2000) -> tuple[float, float]:
    """95 % interval of the Kaplan-Meier median by resampling seeds; nan: beyond the budget."""
    rng = np.random.default_rng(0)
    medians = []
    for _ in range(draws):
        chosen = rng.integers(len(arrived), size=len(arrived))
        medians.append(kaplan_meier_median(arrived.iloc[chosen], made.iloc[chosen]))
    low, high = np.quantile(np.nan_to_num(medians, nan=np.inf), [0.025, 0.975], method="nearest")
    return tuple(float("nan") if np.isinf(x) else float(x) for x in (low, high))


if __name__ == "__main__":
    main()
