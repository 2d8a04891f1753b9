"""Mean regret of every choice on five moving problems: `python -m benchmarks.regret [--seeds 16] [CHOICE]`.

Protocol: 10 Latin hypercube points, then 60 decisions, one step of time each, Gaussian noise of 0.02, fixed
bounds. Score: mean over the 60 decisions of f(u) - min f, the minimum on a 101 x 101 grid. Finished rows of
the table are kept, so the command goes on where it stopped; `--table` only writes the table and the figure
from what is there.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from benchmarks.choices import CHOICES, Build
from benchmarks.moving_problems import GRID, PROBLEMS
from deformpush.experiment.seeding import generator

INITIAL, DECISIONS, NOISE = 10, 60, 0.02
ROOT = Path(__file__).parents[1] / "docs"


def regret(build: Build, problem: str, seed: int) -> tuple[float, float]:
    """Mean regret over the decisions of one run, and its decision time in seconds."""
    f = PROBLEMS[problem](generator(seed, problem))
    noise = generator(seed, f"{problem} noise")
    optimizer = build(generator(seed, f"{problem} optimizer"))
    regrets = []
    spent = 0.0
    for k in range(INITIAL + DECISIONS):
        began = time.perf_counter()
        u = optimizer.ask().u
        spent += time.perf_counter() - began
        value = float(f((u - (0.0, 1.0))[None], k)[0])
        optimizer.tell(u, value + NOISE * noise.normal())
        regrets.append(value - f(GRID, k).min())
    return float(np.mean(regrets[INITIAL:])), spent / DECISIONS


def run(path: Path, names: list[str], seeds: int, problems: list[str]) -> None:
    """Append the missing rows `choice, problem, seed, regret, decision_s` to the file."""
    done = {(r["choice"], r["problem"], int(r["seed"])) for r in rows(path)}
    path.parent.mkdir(parents=True, exist_ok=True)
    for name in names:
        for problem in problems:
            for seed in range(seeds):
                if (name, problem, seed) in done:
                    continue
                value, decision_s = regret(CHOICES[name], problem, seed)
                with path.open("a", newline="") as file:
                    csv.writer(file).writerow([name, problem, seed, f"{value:.6f}", f"{decision_s:.6f}"])
        print(line(name, rows(path)), flush=True)


def rows(path: Path) -> list[dict[str, str]]:
    """What has been measured."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file, ("choice", "problem", "seed", "regret", "decision_s")))


def summary(name: str, table: list[dict[str, str]]) -> tuple[list[tuple[float, float, int]], float, float]:
    """Per problem (mean, standard error, seeds), the mean over problems and its standard error."""
    cells = []
    for problem in PROBLEMS:
        values = [float(r["regret"]) for r in table if r["choice"] == name and r["problem"] == problem]
        error = np.std(values, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan
        cells.append((float(np.mean(values)) if values else np.nan, float(error), len(values)))
    means, errors = np.array(cells)[:, :2].T
    return cells, float(means.mean()), float(np.sqrt(np.sum(errors**2)) / len(errors))


def line(name: str, table: list[dict[str, str]]) -> str:
    """One row of the Markdown table."""
    cells, mean, error = summary(name, table)
    seeds = min(n for _, _, n in cells)
    columns = [f"{m:.3f} ± {e:.3f}" for m, e, _ in cells]
    return f"| {name} | {' | '.join(columns)} | **{mean:.3f}** ± {error:.3f} | {seeds} |"


def report(path: Path) -> None:
    """Write the table beside the data, best first, and the figure."""
    table = rows(path)
    begun = {r["choice"] for r in table}
    # A choice that some problem lacks has no mean yet.
    names = sorted(
        (name for name in begun if not np.isnan(summary(name, table)[1])),
        key=lambda name: summary(name, table)[1],
    )
    head = f"| choice | {' | '.join(PROBLEMS)} | mean | seeds |\n|---|{'---|' * (len(PROBLEMS) + 2)}\n"
    path.with_suffix(".md").write_text(head + "\n".join(line(name, table) for name in names) + "\n")
    figure(path.with_suffix(".png"), names, table)


def figure(path: Path, names: list[str], table: list[dict[str, str]]) -> None:
    """Mean regret with one standard error, best on top."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    means = [summary(name, table)[1:] for name in names]
    outside = {"random", "cmaes", "optuna_gp", "botorch", "botorch w=1", "botorch_default"}
    colours = ["#999999" if name in outside else "#0072b2" for name in names]
    fig, ax = plt.subplots(figsize=(7, 0.24 * len(names) + 1))
    ax.barh(names, [m for m, _ in means], xerr=[e for _, e in means], color=colours, error_kw={"lw": 1})
    ax.invert_yaxis()
    ax.margins(y=0.01)
    ax.set_xlabel("mean regret over five moving problems")
    ax.spines[["top", "right"]].set_visible(False)
    fig.tight_layout()
    fig.savefig(path, dpi=150)


def main() -> None:
    """Run what is missing, then write the table and the figure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("choices", nargs="*", metavar="CHOICE", help=f"any of: {', '.join(CHOICES)}")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--problems", nargs="*", default=list(PROBLEMS), choices=list(PROBLEMS))
    parser.add_argument("--data", type=Path, default=ROOT / "regret.csv")
    parser.add_argument("--table", action="store_true", help="only write the table and the figure")
    arguments = parser.parse_args()
    unknown = set(arguments.choices) - set(CHOICES)
    if unknown:
        parser.error(f"unknown choice {sorted(unknown)}; any of: {', '.join(CHOICES)}")
    if not arguments.table:
        run(arguments.data, arguments.choices or list(CHOICES), arguments.seeds, arguments.problems)
    report(arguments.data)


if __name__ == "__main__":
    main()
