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

from benchmarks.motion import arrival, bootstrap, in_world
from benchmarks.pushing import finished, kaplan_meier_median, number, run_all, seeds_of

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
    parser.add_argument("--world", default="bullet", help="option of the group world")
    parser.add_argument("--table-only", action="store_true", help="only read what is there")
    given = parser.parse_args()
    seeds = seeds_of(given.seeds)
    scenarios = {name: METHODS[name] + in_world(given.world) for name in given.only}
    if not given.table_only:
        jobs = [(scenario, seed) for seed in seeds for scenario in scenarios.values()]
        run_all(given.folder, jobs, "strict", given.processes)
    print(text(given.folder, scenarios, seeds))


def text(folder: Path, scenarios: dict[str, str], seeds: range) -> str:
    """Markdown: one line per method, then the pushes and harmful pushes of every seed."""
    lines = [
        "| acquisition | arrived | and unharmed | median pushes, all (95 %) | harmful pushes | "
        "95 % over seeds | highest strain | speed, median |",
        "|---|---|---|---|---|---|---|---|",
    ]
    each = ["| acquisition | pushes (harmful) of seed " + f"{seeds[0]} to {seeds[-1]} |", "|---|---|"]
    for name, scenario in scenarios.items():
        runs = [finished(folder, scenario, seed, "strict") for seed in seeds]
        rows = [_row(run) if run else None for run in runs]
        made = pd.DataFrame([row for row in rows if row])
        if made.empty:
            continue
        harmful, pushes = int(made.harmful.sum()), int(made.pushes.sum())
        low, high = share_interval(made.harmful, made.pushes)
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
    careful = [scenario for name, scenario in scenarios.items() if name != "lcb"]
    told = [*floor(folder, careful, seeds), *gain(folder, scenarios.get("safe_lcb, contour"), seeds)]
    return "\n".join([*lines, "", *each, *told])


def share_interval(harmful: pd.Series, pushes: pd.Series, draws: int = 2000) -> tuple[float, float]:
    """95 % interval of the share of harmful pushes by resampling seeds: pushes of one run are alike."""
    chosen = np.random.default_rng(0).integers(len(pushes), size=(draws, len(pushes)))
    shares = harmful.to_numpy()[chosen].sum(axis=1) / pushes.to_numpy()[chosen].sum(axis=1)
    low, high = np.quantile(shares, [0.025, 0.975])
    return float(low), float(high)


def floor(folder: Path, scenarios: list[str], seeds: range) -> list[str]:
    """How often the gentlest pushes there are, the slowest and shortest, were harmful all the same."""
    runs = [
        run for scenario in scenarios for seed in seeds if (run := finished(folder, scenario, seed, "strict"))
    ]
    if not runs:
        return []
    made = pd.concat([pd.read_csv(run / "pushes.csv").assign(run=n) for n, run in enumerate(runs)])
    gentlest = made[(made.speed <= 1.01 * made.speed.min()) & (made.d <= 1.01 * made.d.min())]
    by_run = gentlest.groupby("run").limit_exceeded
    harmful, pushes = int(by_run.sum().sum()), len(gentlest)
    low, high = share_interval(by_run.sum(), by_run.count())
    return [
        "",
        f"the slowest and shortest pushes of safe_lcb: {harmful} of {pushes} harmful "
        f"({harmful / pushes:.1%}; {low:.1%} to {high:.1%}), "
        f"median strain {gentlest.strain_p99_peak.median():.3f}",
    ]


def gain(folder: Path, scenario: str | None, seeds: range) -> list[str]:
    """What `acq.contour_gain` and `acq.contour_scatter` would have fitted the pushes made by the contour."""
    found = []
    for seed in seeds if scenario else ():
        run = finished(folder, scenario, seed, "strict")
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
