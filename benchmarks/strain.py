"""What a camera can know of strain: rank correlations of contour measures with the strain of the mesh.

    python -m benchmarks.strain --folder runs/strain --seeds 100-119

Random pushes with the bare tool at random speeds, one after the other from the start and with the material
that each seed draws. Looks at each push are compared with the strain that was measured inside: what the
camera sees in its pictures during the push, the largest of each measure (`watched`, as acq.signal=contour has
it); the last of them alone, when the tool has come to its end (`held`); the picture at rest afterwards
(`after`); and the mesh's own outline at those instants, a camera without pixels (`faultless`).
Pushes that exist are kept, so the command can be stopped and started again.
"""

import argparse
import csv
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.pushing import seeds_of
from deformpush.mechanics.outline_change import ContourChange, contour_change

OBJECTS = ("fish_fillet", "pork", "dough", "tofu", "silicone", "rect", "meat")
COMPARED = (
    ("watched", "p99_peak"),
    ("faultless", "p99_peak"),
    ("held", "p99_peak"),
    ("after", "p99_peak"),
    ("after", "residual"),
)
"""Looks, and the strain that each is held against."""
SPEEDS = (0.03, 0.15)
"""Slowest and fastest push (m/s): what acquisition=safe_lcb chooses from."""
MEASURES = tuple(item.name for item in fields(ContourChange))


def main() -> None:
    """Make the pushes that are missing and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", type=Path, default=Path("runs/strain"))
    parser.add_argument("--objects", nargs="+", default=list(OBJECTS))
    parser.add_argument("--seeds", default="100-119", help="first-last")
    parser.add_argument("--pushes", type=int, default=3, help="from each seed's start")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--table-only", action="store_true", help="only read what is there")
    given = parser.parse_args()
    jobs = [(name, seed) for seed in seeds_of(given.seeds) for name in given.objects]
    if not given.table_only:
        from tqdm import tqdm

        given.folder.mkdir(parents=True, exist_ok=True)
        with ProcessPoolExecutor(given.processes) as pool:
            made = pool.map(partial(sequence, given.folder, given.pushes), jobs)
            for _ in tqdm(made, total=len(jobs), desc="sequences"):
                pass
    files = [file_of(given.folder, *job) for job in jobs if file_of(given.folder, *job).exists()]
    if files:
        rows = pd.concat([pd.read_csv(file) for file in files], ignore_index=True)
        print(strains(rows))
        for look, truth in COMPARED:
            print(correlations(rows, look, truth))


def file_of(folder: Path, name: str, seed: int) -> Path:
    """Where the pushes of one sequence are kept."""
    return folder / f"{name}-{seed}.csv"


def sequence(folder: Path, pushes: int, job: tuple[str, int]) -> None:
    """Make the pushes of one object and seed unless they exist."""
    file = file_of(folder, *job)
    if file.exists():
        return
    rows = [row for _, row in zip(range(pushes), pushed(*job), strict=False)]
    if not rows:
        return
    half = file.with_suffix(".part")
    with half.open("w", newline="") as sink:
        writer = csv.DictWriter(sink, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    half.replace(file)


def pushed(name: str, seed: int) -> Iterator[Mapping[str, Any]]:
    """Random pushes one after the other, until one cannot be made or seen."""
    from deformpush.cell.perception import PerceptionError
    from deformpush.cell.world import WorldError
    from deformpush.checks.physics import rim
    from deformpush.config.compose import compose
    from deformpush.experiment.assemble import build_cell
    from deformpush.experiment.setup import read
    from deformpush.worlds.bullet.world import BulletWorld

    setup = read(compose([f"object={name}", "robot=tool", "task.jitter=true", f"seed={seed}", "record=off"]))
    cell = build_cell(setup)
    assert isinstance(cell.world, BulletWorld), "the default"
    rng = np.random.default_rng(seed)
    low, high = setup.bounds.outer[1]
    try:
        at = cell.look(None)[0].seen
        while True:
            u = np.array([rng.uniform(), rng.uniform(low, high)])
            u, path = cell.reachable(u, at)
            rest, (unpressed,) = rim(cell.world.mesh, cell.world.nodes()), cell.outlines([cell.world.nodes()])
            path = replace(path, speed=rng.uniform(*SPEEDS))
            outcome = cell.world.push(path)
            assert outcome.strain is not None, "Bullet measures it"
            before = at
            at = cell.look(before)[0].seen
            looks = [contour_change(unpressed, contour) for contour in cell.outlines(outcome.film)]
            outlines = [rim(cell.world.mesh, nodes) for nodes in outcome.film]
            seen = {
                "watched": largest(looks),
                "faultless": largest([contour_change(rest, outline) for outline in outlines]),
                "held": looks[-1],
                "after": contour_change(before.contour, at.contour),
            }
            row = {"object": name, "seed": seed, "kappa": u[0], "d": u[1], "speed": path.speed}
            row |= {name: value for name, value in vars(outcome.strain).items() if name != "at_nodes"}
            for kind, change in seen.items():
                row |= {f"{kind}_{measure}": value for measure, value in vars(change).items()}
            yield row
    except (WorldError, PerceptionError) as problem:
        print(f"{name}, seed {seed}: {problem}")
    finally:
        cell.world.close()


def largest(changes: Sequence[ContourChange]) -> ContourChange:
    """The value farthest from zero of every measure."""
    return ContourChange(*(max((getattr(one, name) for one in changes), key=abs) for name in MEASURES))


def strains(rows: pd.DataFrame) -> str:
    """Markdown: how much each object was strained, and how well the dent that was seen tells it."""
    heads = ["object", "pushes", "p99 peak", "top 10 % peak", "maximum", "residual", "limit", "beyond it"]
    heads += ["strain over dent", "scatter of its log"]
    lines = [f"\n| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for name, some in rows.groupby("object", sort=False):
        limit = some["limit"].iloc[0]
        over = "-" if np.isnan(limit) else f"{(some['p99_peak'] > limit).mean():.0%}"
        spread = [quartiles(some[column]) for column in ("p99_peak", "top10_peak", "max_peak", "residual")]
        told = "-" if np.isnan(limit) else f"{limit:.2f}"
        gain = np.log(some["p99_peak"] / some["watched_dent"])
        seen = f"{np.exp(gain.mean()):.2f} | {gain.std():.2f}"
        lines.append(f"| {name} | {len(some)} | {' | '.join(spread)} | {told} | {over} | {seen} |")
    return "\n".join(lines)


def quartiles(values: pd.Series) -> str:
    """Median and middle half, in percent."""
    low, middle, high = 100 * np.quantile(values, [0.25, 0.5, 0.75])
    return f"{middle:.1f} ({low:.1f} to {high:.1f}) %"


def correlations(rows: pd.DataFrame, look: str, truth: str) -> str:
    """Markdown: Spearman's rho of each measure with the strain, object by object and all together."""
    lines = [f"\n`{look}`, rank correlation with `{truth}`", ""]
    lines += [f"| object | pushes | {' | '.join(MEASURES)} |", "|---" * (2 + len(MEASURES)) + "|"]
    groups = [*rows.groupby("object", sort=False), ("all", rows)]
    for name, some in groups:
        seen = [some[f"{look}_{measure}"].abs() for measure in MEASURES]
        cells = [f"{one.corr(some[truth], method='spearman'):+.2f}" for one in seen]
        lines.append(f"| {name} | {len(some)} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
