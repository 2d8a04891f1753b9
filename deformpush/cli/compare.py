"""The verb `compare`: runs as a table, as compare.csv, as a figure and side by side in compare.rrd."""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from deformpush.record.finished import FinishedRun
    from deformpush.study.variants import Variant

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
    from deformpush.cli import output

    output.add_overwrite(parser)
    given = parser.parse_args(argv)

    from deformpush.record.folder import write_whole
    from deformpush.study.find_runs import gather, is_run
    from deformpush.study.tables import table_csv
    from deformpush.study.variants import differing, variants

    only = Path(given.runs[0])
    sweep = len(given.runs) == 1 and only.is_dir() and not is_run(only)
    out = Path(given.out) if given.out else only if sweep else Path()
    table, figure, recording = (out / name for name in FILES)
    output.free([table, figure, recording], given.overwrite)
    found = gather(given.runs)
    difference = differing(found.runs)
    groups = variants(found.runs, difference)
    tell(found.runs, difference, groups)
    for name, reason in found.skipped:
        print(f"skipped {name}: {reason}", file=sys.stderr)

    write_whole(table, table_csv(found.runs, difference).encode())
    from deformpush.study import compare_figure as overlay

    write_whole(figure, overlay.draw(groups))
    output.write(recording, lambda path: record(path, found.runs, difference, groups))
    print(f"written:   {table}, {figure.name}, {recording.name} (rerun {recording})")
    return 0


def tell(
    runs: "Sequence[FinishedRun]", difference: dict[str, list[Any]], groups: "Sequence[Variant]"
) -> None:
    """Print the tables that fit a terminal."""
    from deformpush.study.tables import MOST_KEYS, MOST_ROWS, counted, run_rows, terminal, variant_rows

    if len(runs) <= MOST_ROWS:
        print(terminal(run_rows(runs, difference, MOST_KEYS)), end="\n\n")
    if len(groups) < len(runs) or len(runs) > MOST_ROWS:
        print(terminal(variant_rows(groups)), counted(groups), sep="\n", end="\n\n")
    print("differing: " + (", ".join(difference) or "nothing; the runs have the same settings"))
    commits = Counter(run.commit for run in runs)
    if len(commits) > 1:
        print("versions:  " + ", ".join(f"{commit} ({n} runs)" for commit, n in commits.most_common()))


def record(
    path: Path, runs: "Sequence[FinishedRun]", difference: dict[str, list[Any]], groups: "Sequence[Variant]"
) -> None:
    """Write compare.rrd."""
    from deformpush.study import compare_recording as overview
    from deformpush.viewer import comparison as side_by_side

    names = overview.short_names(runs, difference)
    side_by_side.save(
        path,
        overview.sights(runs, groups, names),
        overview.lines(groups, names),
        overview.stops(runs),
        overview.about(runs, difference, groups),
    )
