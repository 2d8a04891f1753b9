"""Runs as rows: for the terminal and for compare.csv."""

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from deformpush.record.finished import ERRORS, FinishedRun
from deformpush.study.variants import SEED, Variant, show

KNOWN = ("object", "model", "acquisition", SEED)
"""Settings that have a column of their own."""
MOST_KEYS = 5
MOST_ROWS = 60
"""Of the terminal; compare.csv has all."""

COUNTED = "Pushes: median (range). Errors and time: medians over all runs, at the goal or not."
UNHARMED = "Unharmed: reached the goal, and no push strained the object beyond its limit."
"""What the cells of `variant_rows` count."""

Rows = list[list[str]]


def counted(variants: Sequence[Variant]) -> str:
    """What the cells of `variant_rows` count, in words."""
    return COUNTED if all(one.unharmed is None for one in variants) else f"{COUNTED} {UNHARMED}"


def run_rows(runs: Sequence[FinishedRun], difference: dict[str, list[Any]], keys: int = 10**6) -> Rows:
    """Header and a row a run, as people read them."""
    shown = [key for key in difference if key not in KNOWN][:keys]
    watched = any(run.summary.exceedances is not None for run in runs)
    header = ["object", "model", "acquisition", "seed", *shown, "status", "pushes", *["harmful"] * watched]
    header += [f"{error.name} ({error.unit})" for error in ERRORS[:3]] + [
        "e_T",
        "time (s)",
        "simulator (s)",
        "run",
    ]
    rows = [header]
    for i, run in enumerate(runs):
        made = run.summary
        row = [made.object, made.model, made.acquisition, str(made.seed)]
        row += [show(difference[key][i]) for key in shown]
        row += [made.status, str(made.pushes)]
        row += ["-" if made.exceedances is None else str(made.exceedances)] * watched
        row += final_errors(run)
        rows.append([*row, f"{made.wall_s:.1f}", f"{made.step_s:.1f}", run.name])
    return rows


def variant_rows(variants: Sequence[Variant]) -> Rows:
    """Header and a row a variant: how many reached the goal, and medians; see `counted`.

    A run that did not reach the goal has made as many pushes as it was given, not as many as it needs. So
    pushes are counted twice: over the runs that reached it, and over all.
    """
    watched = any(one.unharmed is not None for one in variants)
    header = ["variant", "runs", "reached", *["unharmed"] * watched, "pushes, reached", "pushes, all runs"]
    header += [f"{error.name} ({error.unit})" for error in ERRORS[:3]] + ["e_T", "time (s)"]
    rows = [header]
    for one in variants:
        arrived = [run.summary.pushes for run in one.runs if run.summary.status == "reached"]
        last = [np.median([run.error(error)[-1] for run in one.runs]) for error in ERRORS]
        row = [one.label, str(len(one.runs)), str(one.reached)]
        row += ["-" if one.unharmed is None else str(one.unharmed)] * watched
        row += [_middle(arrived), _middle([run.summary.pushes for run in one.runs])]
        row += [f"{value:.{error.digits}f}" for value, error in zip(last, ERRORS, strict=True)]
        rows.append([*row, f"{np.median([run.summary.wall_s for run in one.runs]):.1f}"])
    return rows


def _middle(counts: Sequence[int]) -> str:
    """Median and range, as far as there is one."""
    spread = f" ({min(counts)} to {max(counts)})" if len(counts) > 1 else ""
    return f"{np.median(counts):g}{spread}" if counts else "-"


def final_errors(run: FinishedRun) -> list[str]:
    """The last errors in the order of `ERRORS`."""
    return [f"{run.error(error)[-1]:.{error.digits}f}" for error in ERRORS]


def terminal(rows: Rows) -> str:
    """Rows in columns of equal width, numbers to the right; the last column is as wide as it is."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    right = [all(is_number(row[i]) for row in rows[1:]) for i in range(len(widths))]
    lines = []
    for row in rows:
        cells = [
            cell.rjust(width) if to_right else cell.ljust(width)
            for cell, width, to_right in zip(row, widths, right, strict=True)
        ]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def table_csv(runs: Sequence[FinishedRun], difference: dict[str, list[Any]]) -> str:
    """A row a run: name, commit, every setting that differs, and all of summary.json."""
    shown = [key for key in difference if key not in KNOWN]
    text = io.StringIO()
    writer: csv.DictWriter[str] | None = None
    for i, run in enumerate(runs):
        row: dict[str, Any] = {"run": run.name, "commit": run.commit}
        row |= {key: show(difference[key][i]) for key in shown}
        row |= {k: "" if v != v else v for k, v in asdict(run.summary).items()}  # nan is an empty cell
        if writer is None:
            writer = csv.DictWriter(text, list(row), lineterminator="\n")
            writer.writeheader()
        writer.writerow(row)
    return text.getvalue()


def is_number(text: str) -> bool:
    """Whether a cell holds a number, or stands for one that is missing."""
    try:
        float(text)
    except ValueError:
        return text == "-"
    return True
