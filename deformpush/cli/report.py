"""The verb `report`: one HTML page of a run or a sweep that needs no network and no other file."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from deformpush.cli import output
from deformpush.errors import UserError

REPORT = "report.html"


@dataclass(frozen=True)
class Defaults:
    """The configuration of a run without overrides."""

    settings: Mapping[str, object]
    options: Mapping[str, str]


def main(argv: Sequence[str]) -> int:
    """Write the page; exit code 0.

    Raises:
        UserError: there is no finished run, or the page exists already.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush report",
        description="Write one HTML page of a run or a sweep; it needs no network and no other file.",
    )
    parser.add_argument("run", metavar="RUN|SWEEP", help="folder of a run, or of several")
    parser.add_argument("--out", metavar="HTML", help=f"where to write (default: {REPORT} in that folder)")
    output.add_overwrite(parser)
    given = parser.parse_args(argv)

    from deformpush.record.files import write_whole
    from deformpush.study.find_runs import find_runs, is_run

    folder = Path(given.run)
    page = Path(given.out) if given.out else folder / REPORT
    found = find_runs([folder])
    output.make_room([page], given.overwrite)
    for name, reason in found.skipped:
        print(f"skipped {name}: {reason}", file=sys.stderr)
    if is_run(folder):
        from deformpush.study.run_page import run_page

        try:
            text = run_page(found.runs[0], defaults())
        except (OSError, ValueError) as error:
            raise UserError(f"{folder}: {error}") from error
    else:
        from deformpush.study.sweep_page import sweep_page

        text = sweep_page(folder.resolve().name, found)
    with output.writing(page):
        write_whole(page, text.encode())
    print(f"written:   {page} ({len(text) / 1e6:.1f} MB)")
    return 0


def defaults() -> Defaults:
    """What a run without overrides would be made with."""
    from deformpush.config.build import plain
    from deformpush.config.compose import compose
    from deformpush.record.finished import flat

    whole = plain(compose([]))
    options = whole.pop("options")
    return Defaults(flat(whole), options)
