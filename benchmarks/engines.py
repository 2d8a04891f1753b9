"""Do the engines agree, and what does a push cost in each: `python -m benchmarks.engines`.

    python -m benchmarks.engines speed
    python -m benchmarks.engines pushes --count 40
    python -m benchmarks.engines methods --seeds 0-19

`pushes` makes the same random pushes in every engine, each from the same start, and compares where the object
comes to lie and how much it was strained. `methods` runs five optimizers in both engines and compares their
ranks. Rows and runs that exist are kept, so each can be stopped and started again.
"""

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
import pandas as pd

from benchmarks.fragile import share_interval
from benchmarks.motion import arrival, in_world
from benchmarks.pushing import finished, kaplan_meier_median, number, result, run_all, seeds_of
from deformpush.cell.cell import Cell
from deformpush.config.compose import compose
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.setup import Setup, read
from deformpush.mechanics.geometry import matched_turn, resample

OBJECTS = ("rect", "meat", "fish_fillet")
ENGINES = {
    "bullet": ["world=bullet"],
    "bullet, half step": ["world=bullet", "world.engine.dt={half}"],
    "mujoco": ["world=mujoco"],
    "mujoco, Bullet's step": ["world=mujoco", "world.engine.dt_scale=1"],
}
METHODS = {
    "abo": "optimizer=abo",
    "abo_motion": "optimizer=abo_motion",
    "safe_lcb": "optimizer=abo_motion,acquisition=safe_lcb",
    "greedy": "optimizer=greedy",
    "random": "optimizer=random",
}
SCENARIO = "experiment=rect_turned,robot=tool,max_pushes=60,object.strain_limit=0.12"
"""A limit that rect, which stands for no real material, does not have: it gives harm something to count."""
BUDGET = 60


def main() -> None:
    """Run what is asked for and print its table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", nargs="?", choices=["speed", "pushes", "methods"], default="speed")
    parser.add_argument("--folder", type=Path, default=Path("runs/engines"))
    parser.add_argument("--objects", nargs="+", default=list(OBJECTS))
    parser.add_argument("--count", type=int, default=40, help="pushes of each object in each engine")
    parser.add_argument("--speed", type=float, help="of the tool in pushes (m/s); default: the world's own")
    parser.add_argument("--seeds", default="0-19", help="first-last")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--table-only", action="store_true", help="only read what is there")
    given = parser.parse_args()
    if given.what == "speed":
        for name in given.objects:
            print(speed(name), flush=True)
    elif given.what == "pushes":
        given.folder.mkdir(parents=True, exist_ok=True)
        for name in given.objects:
            at = "" if given.speed is None else f"-{given.speed:g}"
            file = given.folder / f"pushes-{name}{at}.csv"
            if not given.table_only:
                push_all(name, given.count, file, given.speed)
            print(agreement(name, pd.read_csv(file)), flush=True)
    else:
        seeds = seeds_of(given.seeds)
        if not given.table_only:
            jobs = [(job(name, world), seed) for seed in seeds for world in WORLDS for name in METHODS]
            run_all(given.folder, jobs, "strict", given.processes)
        print(ranks(given.folder, seeds))


def settings(name: str, engine: str) -> Setup:
    """An object with the bare tool in an engine."""
    half = read(compose([f"object={name}"])).object.dt / 2
    return read(compose([f"object={name}", "robot=tool", *(x.format(half=half) for x in ENGINES[engine])]))


def random_pushes(setup: Setup, count: int) -> np.ndarray:
    """Pushes (kappa, d) `(count, 2)`, the same for every engine."""
    shortest, longest = setup.object.d
    share = np.random.default_rng(2026).uniform(size=(count, 2))
    return share * (1.0, longest - shortest) + (0.0, shortest)


# --- What a push costs


def speed(name: str, count: int = 12) -> str:
    """Seconds of CPU a push: a chain of the same random pushes, all engines in turn."""
    setups = {engine: settings(name, engine) for engine in ENGINES}
    cells = {engine: build_cell(setup) for engine, setup in setups.items()}
    seen = dict.fromkeys(ENGINES)
    seconds = pd.DataFrame(0.0, index=range(count), columns=list(ENGINES))
    for n, u in enumerate(random_pushes(setups["bullet"], count)):
        for engine, cell in cells.items():
            look = cell.look(seen[engine])[0].seen
            path = cell.reachable(u, look)[1]
            began = process_time()
            cell.world.push(path)
            seconds.loc[n, engine] = process_time() - began
            seen[engine] = look
    lines = [
        f"\n{name}: CPU seconds a push, mean of {count}",
        "",
        "| engine | s | Bullet takes |",
        "|---|---|---|",
    ]
    for engine, mean in seconds.mean().items():
        times = seconds["bullet"].mean() / mean
        lines.append(f"| {engine} | {mean:.3f} | {times:.1f} times |")
    return "\n".join(lines)


# --- Whether they agree


def push_all(name: str, count: int, file: Path, speed: float | None) -> None:
    """Make the missing pushes; a row is written for each as soon as it is made."""
    from tqdm import tqdm

    done = len(pd.read_csv(file)) if file.exists() else 0
    pushes = random_pushes(settings(name, "bullet"), count)
    for n in tqdm(range(done, count), desc=name):
        row = {"n": n, "kappa": pushes[n, 0], "d": pushes[n, 1]}
        for engine in ENGINES:
            cell = build_cell(settings(name, engine))
            row |= {f"{engine}: {key}": value for key, value in one_push(cell, pushes[n], speed).items()}
            cell.world.close()
        pd.DataFrame([row]).to_csv(file, mode="a", header=not file.exists(), index=False)


def one_push(cell: Cell, u: np.ndarray, speed: float | None) -> dict[str, float]:
    """How far the object's nodes moved (mm, degrees), and how much they were strained."""
    before = cell.look(None)[0].seen
    start = cell.world.nodes()
    outcome = cell.world.push(replace(cell.plan(u, before), speed=speed))
    end, after = cell.world.nodes(), cell.look(before)[0].seen
    assert start is not None
    assert end is not None
    assert outcome.strain is not None
    x, y = 1e3 * (end - start)[:, :2].mean(axis=0)
    turn = matched_turn(*(resample(seen.contour, 256) - seen.c for seen in (before, after)))
    return {"x": x, "y": y, "turn": np.degrees(turn), "strain": outcome.strain.p99_peak}


def agreement(name: str, rows: pd.DataFrame) -> str:
    """Differences from Bullet at its step: median, 95 % quantile, largest."""
    lines = [
        f"\n{name}, {len(rows)} pushes, beside Bullet at its own step (median; 95 %; largest)",
        "",
        "| engine | place (mm) | turn (degrees) | strain p99 | strain, mean | moved (mm) |",
        "|---|---|---|---|---|---|",
    ]
    was = {key: rows[f"bullet: {key}"] for key in ("x", "y", "turn", "strain")}
    for engine in ENGINES:
        now = {key: rows[f"{engine}: {key}"] for key in was}
        moved = np.hypot(now["x"], now["y"]).mean()
        apart = ["", "", "", ""]
        if engine != "bullet":
            ratio = now["strain"] / was["strain"] - 1
            apart = [
                spread(np.hypot(now["x"] - was["x"], now["y"] - was["y"]), "{:.1f}"),
                spread((now["turn"] - was["turn"]).abs(), "{:.1f}"),
                spread(ratio.abs(), "{:.0%}"),
                f"{ratio.mean():+.1%}",
            ]
        lines.append(f"| {engine} | {' | '.join(apart)} | {moved:.1f} |")
    return "\n".join(lines)


def spread(values: pd.Series, form: str) -> str:
    """Median, 95 % quantile and maximum."""
    return "; ".join(form.format(x) for x in (values.median(), values.quantile(0.95), values.max()))


# --- Whether methods rank alike

WORLDS = ("bullet", "mujoco")


def job(method: str, world: str) -> str:
    """Overrides of a run, with commas between."""
    return f"{SCENARIO},{METHODS[method]}{in_world(world)}"


def ranks(folder: Path, seeds: Sequence[int]) -> str:
    """Pushes and harmful pushes of every method in both engines, and Kendall's tau of each ranking."""
    lines = [
        "| method | world | arrived | median, all | mean, at most 60 | harmful (95 % over seeds) |",
        "|---|---|---|---|---|---|",
    ]
    each = [f"| method | world | pushes of seed {seeds[0]} to {seeds[-1]} |", "|---|---|---|"]
    made = {}
    for method in METHODS:
        for world in WORLDS:
            rows = [result(folder, job(method, world), seed, "strict") for seed in seeds]
            each.append(f"| {method} | {world} | {', '.join(arrival(row) for row in rows)} |")
            table = pd.DataFrame([row or {"seed": seed} for row, seed in zip(rows, seeds, strict=True)])
            if len(table.columns) == 1:
                continue
            table["harmful"] = [harmful(folder, job(method, world), seed) for seed in seeds]
            made[method, world] = table
            whole = table.dropna(subset="pushes")
            low, high = share_interval(whole.harmful, whole.pushes)
            share = whole.harmful.sum() / whole.pushes.sum()
            lines.append(
                f"| {method} | {world} | {whole.strict.notna().sum()} of {len(whole)} | "
                f"{number(kaplan_meier_median(whole.strict, whole.pushes))} | {cost(table).mean():.1f} | "
                f"{share:.0%} ({low:.0%} to {high:.0%}) |"
            )
    if len(made) == len(METHODS) * len(WORLDS):
        pushes = {key: cost(table).to_numpy() for key, table in made.items()}
        harm = {key: (table.harmful / table.pushes).to_numpy() for key, table in made.items()}
        lines += [
            "",
            f"Kendall's tau between the engines: pushes {tau(pushes)}, share of harmful pushes {tau(harm)}",
        ]
    return "\n".join([*lines, "", *each])


def harmful(folder: Path, scenario: str, seed: int) -> float:
    """Pushes of a run that went beyond the limit."""
    run = finished(folder, scenario, seed, "strict")
    return float("nan") if run is None else float(pd.read_csv(run / "pushes.csv").limit_exceeded.sum())


def cost(table: pd.DataFrame) -> pd.Series:
    """Pushes to the goal; one that never came counts with the budget, however it ended."""
    return table.strict.fillna(BUDGET)


def tau(values: dict[tuple[str, str], np.ndarray], draws: int = 2000) -> str:
    """Kendall's tau-b of the methods' means in the two engines, with its 95 % interval over seeds."""
    from scipy.stats import kendalltau

    each = [np.stack([values[method, world] for method in METHODS]) for world in WORLDS]
    rng = np.random.default_rng(0)
    draws_of = rng.integers(each[0].shape[1], size=(draws, each[0].shape[1]))
    found = [kendalltau(*(x[:, chosen].mean(axis=1) for x in each)).statistic for chosen in draws_of]
    low, high = np.nanquantile(found, [0.025, 0.975])
    return f"{kendalltau(*(x.mean(axis=1) for x in each)).statistic:.2f} ({low:.2f} to {high:.2f})"


if __name__ == "__main__":
    main()
