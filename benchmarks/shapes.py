"""Eight outlines, from a disc to a ring sector, in both engines: `python -m benchmarks.shapes`.

Each starts and ends as `experiment=rect_straight` says, 0.2 m apart, with start, goal and material jittered.
Runs that exist are kept, so the command can be stopped and started again.
"""

import argparse
import os
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.motion import in_world
from benchmarks.outlines import OUTLINES, settings
from benchmarks.pushing import kaplan_meier_median, number, result, run_all, seeds_of

SCENARIO = "experiment=rect_straight,optimizer=abo_motion"
BUDGET = 40
DISTANCE, LONGEST = 0.2, 0.03
"""To the goal, and of a push (m)."""
ALLOWED = 1.6


def main() -> None:
    """Run what is missing and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", type=Path, default=Path("runs/shapes"))
    parser.add_argument("--seeds", default="0-9", help="first-last")
    parser.add_argument("--outlines", nargs="+", choices=OUTLINES, default=list(OUTLINES))
    parser.add_argument("--worlds", nargs="+", default=["mujoco", "bullet"])
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--options", default="", help="more overrides, with commas between")
    parser.add_argument("--table-only", action="store_true", help="only read what is there")
    given = parser.parse_args()
    seeds = seeds_of(given.seeds)
    names = {(n, w): job(n, w, given.options) for w in given.worlds for n in given.outlines}
    if not given.table_only:
        jobs = [(scenario, seed) for seed in seeds for scenario in names.values()]
        run_all(given.folder, jobs, "strict", given.processes, {name: settings(name) for name in OUTLINES})
    print(text(given.folder, names, seeds))


def job(outline: str, world: str, options: str) -> str:
    """Overrides, with commas between; the outline stands for those that make it."""
    more = f",{options}" if options else ""
    return f"{SCENARIO},{outline},max_pushes={BUDGET}{in_world(world)}{more}"


def text(folder: Path, names: dict[tuple[str, str], str], seeds: range) -> str:
    """Markdown: a line an outline and world."""
    most = ALLOWED * DISTANCE / LONGEST
    lines = [
        f"| outline | world | reached | median, all (allowed {most:.1f}) | worst | pushes of each seed |",
        "|---|---|---|---|---|---|",
    ]
    for (outline, world), scenario in names.items():
        rows = [result(folder, scenario, seed, "strict") for seed in seeds]
        made = pd.DataFrame([row for row in rows if row])
        if made.empty:
            continue
        arrived = made.strict.notna()
        median = kaplan_meier_median(made.strict, made.pushes)
        each = ", ".join(
            number(row.strict) if not np.isnan(row.strict) else row.failure or f"not in {row.pushes}"
            for row in made.itertuples()
        )
        worst = number(made.strict.max()) if arrived.all() else f"over {made.pushes.max()}"
        lines.append(
            f"| {outline} | {world} | {arrived.sum()} of {len(made)} | {number(median)} | {worst} | {each} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
