"""The verb `status`: which runs of a folder are done, running, failed or still to come."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from deformpush.errors import TroubleError, UserError

if TYPE_CHECKING:
    from deformpush.experiment.sweep.status import Overview

MOST = 20
"""Reasons shown; sweep.csv has all."""
EXPLAINED = ("failed", "refused", "interrupted")
"""States of runs whose reasons are shown."""


def main(argv: Sequence[str]) -> int:
    """Tell how far a sweep is, and write its sweep.csv; exit code 0.

    Raises:
        UserError: no run is there.
        TroubleError: sweep.csv cannot be written.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush status",
        description="Tell which runs of a folder are done, running, interrupted, failed or to come, why, "
        "and how long it will take. In the folder of a sweep it writes sweep.csv.",
    )
    parser.add_argument("folder", nargs="?", default="runs", type=Path, help="of a sweep, or of any runs")
    given = parser.parse_args(argv)
    if not given.folder.is_dir():
        raise UserError(f"{given.folder}: no such folder")
    from deformpush.experiment.sweep.status import look

    overview = look(given.folder)
    if not any(entry.is_now.state != "pending" for entry in overview.entries) and not overview.sweep:
        raise UserError(f"{given.folder}: holds no runs")
    print(tell(overview))
    return 0


def tell(overview: "Overview") -> str:
    """Describe a folder in a few lines; in that of a sweep, write sweep.csv too."""
    from deformpush.experiment.sweep.status import states, write_table

    rows = [(state, str(number), remark) for state, number, remark in states(overview)]
    width = max(len(number) for _, number, _ in rows)
    lines = [f"{overview.folder}: {len(overview.entries)} runs"]
    lines += [f"  {state:<12}{number:>{width}}  {remark}".rstrip() for state, number, remark in rows]
    left = overview.time_left_s()
    if left is not None:
        lines.append(f"  time left   about {_duration(left)}")
    explained = [entry for entry in overview.entries if entry.is_now.state in EXPLAINED]
    for entry in explained[:MOST]:
        lines.append(f"{entry.is_now.state}: {entry.job.name}: {entry.is_now.text}")
    if len(explained) > MOST:
        lines.append(f"... and {len(explained) - MOST} more")
    if overview.sweep:
        try:
            lines.append(f"table: {write_table(overview)}")
        except OSError as error:
            raise TroubleError(f"{overview.folder}: cannot write sweep.csv ({error.strerror})") from error
    return "\n".join(lines)


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
