"""Runs and variants as rows: for the terminal, for pages and for compare.csv."""

import csv
import io
from collections.abc import Sequence

import numpy as np

from deformpush.record.finished import FinishedRun
from deformpush.study.variants import SEED, Differences, Variant, show
from deformpush.task import TERMS, TOTAL

Rows = list[list[str]]
"""A header and rows of as many cells."""

OWN_COLUMNS = ("object", "model", "acquisition", SEED)
"""Settings that have a column of their own."""
MOST_KEYS, MOST_ROWS = 5, 60
"""Settings and runs that a terminal shows; compare.csv has all."""
ERROR_HEADER = [*(f"{term.name} ({term.unit})" for term in TERMS), TOTAL.symbol]
SHOWN_ERRORS = (*TERMS, TOTAL)

CAPTION = "Pushes: median (range). Errors and time: medians over all runs, at the goal or not."
UNHARMED = "Unharmed: reached the goal, and no push went beyond a limit of the object."


def caption(variants: Sequence[Variant]) -> str:
    """What the cells of `variant_rows` say."""
    return CAPTION if all(one.unharmed is None for one in variants) else f"{CAPTION} {UNHARMED}"


def run_rows(runs: Sequence[FinishedRun], differences: Differences, keys: int = 10**6) -> Rows:
    """Header and a row a run, as people read them; at most `keys` of the settings that differ."""
    shown = [key for key in differences if key not in OWN_COLUMNS][:keys]
    watched = any(run.summary.exceedances is not None for run in runs)
    header = ["object", "model", "acquisition", "seed", *shown, "status", "pushes", *["harmful"] * watched]
    rows = [[*header, *ERROR_HEADER, "time (s)", "simulator (s)", "run"]]
    for i, run in enumerate(runs):
        made = run.summary
        row = [made.object, made.model, made.acquisition, str(made.seed)]
        row += [show(differences[key][i]) for key in shown]
        row += [made.status, str(made.pushes)]
        row += ["-" if made.exceedances is None else str(made.exceedances)] * watched
        row += error_cells([run.error(quantity)[-1] for quantity in SHOWN_ERRORS])
        rows.append([*row, f"{made.wall_s:.1f}", f"{made.step_s:.1f}", run.name])
    return rows


def variant_rows(variants: Sequence[Variant]) -> Rows:
    """Header and a row a variant: how many reached the goal, and medians; see `caption`.

    A run that did not reach the goal has made as many pushes as it was given, not as many as it needs. So
    pushes are counted twice: over the runs that reached it, and over all.
    """
    watched = any(one.unharmed is not None for one in variants)
    header = ["variant", "runs", "reached", *["unharmed"] * watched, "pushes, reached", "pushes, all runs"]
    rows = [[*header, *ERROR_HEADER, "time (s)"]]
    for one in variants:
        arrived = [run.summary.pushes for run in one.runs if run.summary.status == "reached"]
        row = [one.label, str(len(one.runs)), str(one.reached)]
        row += ["-" if one.unharmed is None else str(one.unharmed)] * watched
        row += [_median(arrived), _median([run.summary.pushes for run in one.runs])]
        last = [[run.error(quantity)[-1] for run in one.runs] for quantity in SHOWN_ERRORS]
        row += error_cells([float(np.median(values)) for values in last])
        rows.append([*row, f"{np.median([run.summary.wall_s for run in one.runs]):.1f}"])
    return rows


def error_cells(values: Sequence[float]) -> list[str]:
    """Errors in their units, below `ERROR_HEADER`; a dash where a run of another version has none."""
    texts = [f"{value:.{shown.digits}f}" for value, shown in zip(values, SHOWN_ERRORS, strict=True)]
    return ["-" if text == "nan" else text for text in texts]


def _median(counts: Sequence[int]) -> str:
    """Median and range, as far as there is one."""
    spread = f" ({min(counts)} to {max(counts)})" if len(counts) > 1 else ""
    return f"{np.median(counts):g}{spread}" if counts else "-"


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


def markdown(rows: Rows) -> str:
    """Rows as a Markdown table; a bar in a cell would end it."""
    header, *body = [[cell.replace("|", "/") for cell in row] for row in rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in [header, ["---"] * len(header), *body])


def table_csv(runs: Sequence[FinishedRun], differences: Differences) -> str:
    """A row a run: name, commit, every setting that differs, and all of summary.json."""
    shown = [key for key in differences if key not in OWN_COLUMNS]
    rows: list[dict[str, object]] = []
    for i, run in enumerate(runs):
        row: dict[str, object] = {"run": run.name, "commit": run.commit}
        row |= {key: show(differences[key][i]) for key in shown}
        row |= {k: "" if v != v else v for k, v in run.summary.flat().items()}  # nan is an empty cell
        rows.append(row)
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def is_number(text: str) -> bool:
    """Whether a cell holds a number, or stands for one that is missing."""
    try:
        float(text)
    except ValueError:
        return text == "-"
    return True
