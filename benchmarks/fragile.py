"""Pushing under a strain limit: `python -m benchmarks.fragile`.

A fish fillet, 0.2 m straight on, jittered by the seed, `stop=strict`, motion model, budget 80 pushes: plain
LCB, safe_lcb that is told the measured strain, at the default p_safe (0.95) and at 0.99, and safe_lcb that
sees the outline only. A push is harmful when the p99 strain goes beyond the limit of the object at any
instant of it. Runs that exist are kept.
"""

import argparse
import json
import os
from pathlib import Path

import numpy as np
import pandas as pd
from omegaconf import OmegaConf

from benchmarks.motion import arrival, bootstrap
from benchmarks.pushing import finished, kaplan_meier_median, number, run_all, seeds_of, wilson

SCENARIO = "experiment=fish_straight,optimizer=abo_motion"
METHODS = {
    "lcb": f"{SCENARIO},acquisition=lcb",
    "safe_lcb, strain": f"{SCENARIO},acquisition=safe_lcb",
    "safe_lcb, strain, p_safe 0.99": f"{SCENARIO},acquisition=safe_lcb,acq.p_safe=0.99",
    "safe_lcb, contour": f"{SCENARIO},acquisition=safe_lcb,acq.signal=contour",
}


def main() -> None:
    """Run what is missing and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", type=Path, default=Path("runs/fragile"))
    parser.add_argument("--seeds", default="0-19", help="first-last")
    parser.add_argument("--only", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--table-only", action="store_true", help="only read what is there")
    given = parser.parse_args()
    seeds = seeds_of(given.seeds)
    if not given.table_only:
        jobs = [(METHODS[method], seed) for seed in seeds for method in given.only]
        run_all(given.folder, jobs, "strict", given.processes)
    print(text(given.folder, seeds))


def text(folder: Path, seeds: range) -> str:
    """Markdown: one line per method, then the pushes and harmful pushes of every seed."""
    lines = [
        "| acquisition | arrived | and unharmed | median pushes, all (95 %) | harmful pushes | "
        "95 % (Wilson) | highest strain | speed, median |",
        "|---|---|---|---|---|---|---|---|",
    ]
    each = ["| acquisition | pushes (harmful) of seed " + f"{seeds[0]} to {seeds[-1]} |", "|---|---|"]
    for name, scenario in METHODS.items():
        runs = [finished(folder, scenario, seed, "strict") for seed in seeds]
        rows = [_row(run) if run else None for run in runs]
        made = pd.DataFrame([row for row in rows if row])
        if made.empty:
            continue
        harmful, pushes = int(made.harmful.sum()), int(made.pushes.sum())
        low, high = wilson(harmful, pushes)
        shortest, longest = bootstrap(made.strict, made.pushes)
        median = number(kaplan_meier_median(made.strict, made.pushes))
        unharmed = int((made.strict.notna() & (made.harmful == 0)).sum())
        lines.append(
            f"| {name} | {made.strict.notna().sum()} of {len(made)} | {unharmed} | "
            f"{median} ({number(shortest)} to {number(longest)}) | "
            f"{harmful} of {pushes} ({harmful / pushes:.1%}) | {low:.1%} to {high:.1%} | "
            f"{made.peak.max():.3f} | {_speed(made)} |"
        )
        cells = [arrival(row) + (f" ({row['harmful']})" if row else "") for row in rows]
        each.append(f"| {name} | {', '.join(cells)} |")
    return "\n".join([*lines, "", *each, *floor(folder, seeds), *gain(folder, seeds)])


def floor(folder: Path, seeds: range) -> list[str]:
    """How often the gentlest pushes there are, the slowest and shortest, were harmful all the same."""
    runs = [
        run
        for name, scenario in METHODS.items()
        if name != "lcb"
        for seed in seeds
        if (run := finished(folder, scenario, seed, "strict"))
    ]
    if not runs:
        return []
    made = pd.concat([pd.read_csv(run / "pushes.csv") for run in runs])
    gentlest = made[(made.speed <= 1.01 * made.speed.min()) & (made.d <= 1.01 * made.d.min())]
    harmful, pushes = int(gentlest.limit_exceeded.sum()), len(gentlest)
    low, high = wilson(harmful, pushes)
    return [
        "",
        f"the slowest and shortest pushes of safe_lcb: {harmful} of {pushes} harmful "
        f"({harmful / pushes:.1%}; {low:.1%} to {high:.1%}), "
        f"median strain {gentlest.strain_p99_peak.median():.3f}",
    ]


def gain(folder: Path, seeds: range) -> list[str]:
    """What `acq.contour_gain` and `acq.contour_scatter` would have fitted the pushes made by the contour."""
    found = []
    for seed in seeds:
        run = finished(folder, METHODS["safe_lcb, contour"], seed, "strict")
        if run:
            strain = pd.read_csv(run / "pushes.csv").strain_p99_peak.dropna().to_numpy()
            told = np.load(run / "checkpoint.npz")["state.strain_peaks"]
            set_to = OmegaConf.load(run / "config.yaml").acq.contour_gain
            found.append(np.log(strain * set_to / told))
    if not found:
        return []
    each = np.concatenate(found)
    between = np.std([np.mean(one) for one in found], ddof=1) if len(found) > 1 else float("nan")
    return [
        "",
        f"strain over dent in {len(each)} pushes of the contour: {np.exp(each.mean()):.2f}, "
        f"scatter of its log {each.std(ddof=1):.2f}, of which between runs {between:.2f}",
    ]


def _row(run: Path) -> dict[str, float]:
    end = json.loads((run / "summary.json").read_text())
    reached = end["status"] == "reached"
    return {
        "pushes": end["pushes"],
        "strict": float(end["pushes"]) if reached else float("nan"),
        "harmful": end["exceedances"] or 0,
        "peak": end["strain_peak"],
        "speed": pd.read_csv(run / "pushes.csv").speed.median(),
    }


def _speed(made: pd.DataFrame) -> str:
    speed = made.speed.median()
    return "as set" if speed != speed else f"{speed:.3f} m/s"


if __name__ == "__main__":
    main()
