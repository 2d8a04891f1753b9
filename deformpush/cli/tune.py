"""The verb `tune`: settings of the optimizer by which the goal takes the fewest pushes."""

import argparse
import csv
import io
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from deformpush.errors import UserError

if TYPE_CHECKING:
    from deformpush.experiment.tuning.trials import Trial

REPORTED = range(20)
"""Seeds that results are told of; what was chosen on them would look better than it is."""
TABLE = "tune.csv"
MOST = 10
"""Trials shown on the terminal; tune.csv has all."""


def main(argv: Sequence[str]) -> int:
    """Tune, or go on with a tuning; exit code 0 when all trials are made.

    Raises:
        UserError: a setting does not fit, or the folder holds another tuning.
        TroubleError: the folder cannot be written any more; the same command goes on.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush tune",
        description="Search settings of the optimizer (Optuna, TPE). A trial is one run per seed; its "
        "objective is the mean number of pushes to the goal. A run that does not arrive counts as "
        "budget * (1 + share of e_T left), one that fails as twice the budget. The same command again "
        "goes on where it was.",
        epilog="example: python -m deformpush tune 'acq.w=tag(log, interval(0.5, 4))' kernel=matern52,rbf "
        "world=toy robot=tool --trials 20 --out runs/tune/mine",
    )
    parser.add_argument("settings", nargs="+", metavar="KEY=RANGE|KEY=VALUE", help="in Hydra's grammar")
    parser.add_argument("--trials", type=int, default=20, help="in all, earlier ones included (default 20)")
    parser.add_argument("--seeds", default="100-103", help="such as 100-103 or 100,105 (default 100-103)")
    parser.add_argument("--out", type=Path, default=Path("runs/tune/default"), metavar="FOLDER")
    parser.add_argument("--allow-report-seeds", action="store_true", help="seeds 0 to 19 too")
    given = parser.parse_intermixed_args(argv)
    if given.trials < 1:
        raise UserError(f"--trials {given.trials}: must be 1 or more")
    seeds = seeds_of(given.seeds)
    if (kept := sorted(set(seeds) & set(REPORTED))) and not given.allow_report_seeds:
        raise UserError(
            f"--seeds {given.seeds}: {kept[0]} is one of the seeds 0 to 19, on which results are reported; "
            "take others, or say --allow-report-seeds"
        )
    return _tune(given.settings, given.trials, seeds, given.out)


def seeds_of(text: str) -> list[int]:
    """The seeds that "100-103" or "100,105,110-112" names.

    Raises:
        UserError: it names none.
    """
    seeds: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise UserError(f"--seeds {text}: must be numbers and ranges, such as 100-103 or 100,105")
        seeds += range(int(first), int(last or first) + 1)
    if not seeds or len(set(seeds)) < len(seeds):
        raise UserError(f"--seeds {text}: names {'no seed' if not seeds else 'a seed twice'}")
    return seeds


def _tune(settings: Sequence[str], total: int, seeds: Sequence[int], out: Path) -> int:
    from deformpush.config.compose import compose
    from deformpush.experiment.tuning.space import parse, told
    from deformpush.experiment.tuning.trials import Trials
    from deformpush.extras import library
    from deformpush.record.files import write_whole
    from deformpush.record.lock import Lock

    library("optuna", "tune", "tune")
    space = parse(settings)
    compose(space.fixed)  # what is wrong in every trial is said once, before the first
    try:
        out.mkdir(parents=True, exist_ok=True)
        lock = Lock.take(out)
    except OSError as error:
        raise UserError(f"--out {out}: cannot be used as a folder: {error.strerror}") from error
    if lock is None:
        raise UserError(f"--out {out}: another process is at work in this folder")
    try:
        trials = Trials(out, space, seeds)
        for trial in trials.make(total, partial(_runs, seeds, out)):
            objective = f"{trial.mean:.2f} pushes" if trial.costs else f"refused: {trial.reason}"
            print(f"trial {trial.number}: {objective}, {' '.join(told(trial.values))}", flush=True)
            write_whole(out / TABLE, _csv(trials.done(), seeds).encode())
        done = trials.done()
        write_whole(out / TABLE, _csv(done, seeds).encode())
    finally:
        lock.release()
    print(_best(done))
    print(f"table: {out / TABLE}")
    return 0


def _runs(seeds: Sequence[int], out: Path, number: int, overrides: Sequence[str]) -> list[float]:
    """Make the runs of a trial, those that are missing; their costs in pushes."""
    from deformpush.config.compose import compose
    from deformpush.experiment.console import Verbosity
    from deformpush.experiment.sweep.run_or_resume import FailedBeforeError, run_or_resume
    from deformpush.experiment.tuning.cost import cost
    from deformpush.record.folder import RunFolder

    costs = []
    for seed in seeds:
        cfg = compose([*overrides, f"seed={seed}"])
        folder = RunFolder(out / f"trial-{number:03}" / f"seed={seed}")
        with suppress(FailedBeforeError):  # it has a cost too
            run_or_resume(cfg, folder.path, retry=False, verbosity=Verbosity.BAR_ONLY)
        costs.append(cost(folder, cfg.max_pushes))
    return costs


def _best(done: "Sequence[Trial]") -> str:
    """The best trials as a table, and the best one's settings as one types them."""
    from deformpush.experiment.tuning.space import told
    from deformpush.study.tables import terminal

    ranked = sorted((t for t in done if t.costs), key=lambda trial: (trial.mean, trial.number))
    if not ranked:
        return "no trial could be made: " + (done[0].reason if done else "none was asked for")
    keys = list(ranked[0].values)
    rows = [["trial", "objective (pushes)", *keys]]
    rows += [[str(t.number), f"{t.mean:.2f}", *map(_short, t.values.values())] for t in ranked[:MOST]]
    return f"{terminal(rows)}\nbest: {' '.join(told(ranked[0].values))}"


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _csv(done: "Sequence[Trial]", seeds: Sequence[int]) -> str:
    """A row a trial: objective, settings, cost with each seed, and why it was refused."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    keys = list(done[0].values) if done else []
    writer.writerow(["trial", "objective", *keys, *(f"seed={seed}" for seed in seeds), "reason"])
    for trial in done:
        costs: Sequence[object] = trial.costs or [""] * len(seeds)
        objective = repr(trial.mean) if trial.costs else ""
        writer.writerow([trial.number, objective, *trial.values.values(), *costs, trial.reason])
    return text.getvalue()
