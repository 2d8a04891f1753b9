"""The verb `compare`: runs as a table, as compare.csv, as a figure and side by side in compare.rrd."""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from deformpush.cli import output

if TYPE_CHECKING:
    from deformpush.record.finished import FinishedRun
    from deformpush.study.variants import Differences, Variant

FILES = ("compare.csv", "compare.png", "compare.rrd")


def main(argv: Sequence[str]) -> int:
    """Compare finished runs; exit code 0 when there was something to compare.

    Raises:
        UserError: no finished run is named, or the files to write are there already.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush compare",
        description="Compare finished runs: a table here, and compare.csv, compare.png, compare.rrd.",
    )
    parser.add_argument("runs", nargs="+", metavar="RUN|SWEEP_FOLDER", help="folders of runs, or of sweeps")
    parser.add_argument(
        "--out", metavar="DIR", help="where to write (default: the one folder named, else here)"
    )
    output.add_overwrite(parser)
    given = parser.parse_args(argv)

    from deformpush.record.files import replacing, write_whole
    from deformpush.study.find_runs import find_runs, is_run
    from deformpush.study.tables import table_csv
    from deformpush.study.variants import differing, variants

    only = Path(given.runs[0])
    sweep = len(given.runs) == 1 and only.is_dir() and not is_run(only)
    out = Path(given.out) if given.out else only if sweep else Path()
    table, figure, recording = (out / name for name in FILES)
    output.make_room([table, figure, recording], given.overwrite)
    found = find_runs(given.runs)
    differences = differing(found.runs)
    groups = variants(found.runs, differences)
    print(text(found.runs, differences, groups))
    for name, reason in found.skipped:
        print(f"skipped {name}: {reason}", file=sys.stderr)

    from deformpush.study import compare_figure, compare_recording

    with output.writing(table):
        write_whole(table, table_csv(found.runs, differences).encode())
    picture = compare_figure.draw(groups)
    with output.writing(figure):
        write_whole(figure, picture)
    with output.writing(recording), replacing(recording) as made:
        compare_recording.write(made, found.runs, differences, groups)
    print(f"written:   {table}, {figure.name}, {recording.name} (rerun {recording})")
    return 0


def text(runs: "Sequence[FinishedRun]", differences: "Differences", groups: "Sequence[Variant]") -> str:
    """What the terminal shows: the tables that fit it, what differs, versions of the code."""
    from deformpush.study.tables import MOST_KEYS, MOST_ROWS, caption, run_rows, terminal, variant_rows

    lines = []
    if len(runs) <= MOST_ROWS:
        lines += [terminal(run_rows(runs, differences, MOST_KEYS)), ""]
    if len(groups) < len(runs) or len(runs) > MOST_ROWS:
        lines += [terminal(variant_rows(groups)), caption(groups), ""]
    lines += ["differing: " + (", ".join(differences) or "nothing; the runs have the same settings")]
    commits = Counter(run.commit for run in runs)
    if len(commits) > 1:
        lines += ["versions:  " + ", ".join(f"{commit} ({n} runs)" for commit, n in commits.most_common())]
    return "\n".join(lines)
