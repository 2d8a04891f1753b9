"""A push made in two ways: what each did, and compare.rrd with the bottom views side by side."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from deformpush.push_record import PushRecord
from deformpush.record import palette, table
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_pictures, read_poses
from deformpush.study.tables import Rows
from deformpush.task import TERMS, TOTAL
from deformpush.viewer import comparison
from deformpush.viewer.comparison import Line, Sight


def write(path: Path, runs: Sequence[tuple[str, RunFolder]], about: str) -> None:
    """Write the recording.

    Args:
        path: the file.
        runs: title and folder of each; also of one that was killed, as far as it came.
        about: what is compared, as Markdown.

    Raises:
        OSError, ValueError: a file of a run cannot be read.
    """
    sights, lines = [], []
    for (title, folder), colour in zip(runs, palette.RUNS, strict=False):
        poses, pictures = read_poses(folder.contours), read_pictures(folder.views)
        columns = table.columns(folder.table)
        ended = f"after push {len(columns['k']) - 1}"
        sights.append(Sight(title, ended, poses, pictures))
        errors = {
            one.name: np.abs(np.asarray(columns[one.column], float)) * one.scale for one in (*TERMS, TOTAL)
        }
        lines.append(Line(title, colour, errors))
    stops = {term.name: [stop * term.scale] for term, stop in zip(TERMS, sights[0].poses.stops, strict=True)}
    comparison.save(path, sights, lines, stops, about)


def rows(before: PushRecord, made: PushRecord, other: PushRecord) -> Rows:
    """A header, then a row a quantity: as the push was made, and as the other one would have been."""
    columns = [_told(before, record) for record in (made, other)]
    names = [name for name in columns[0] if any(column[name] != "-" for column in columns)]
    return [["", "made", "what if"], *([name, *(column[name] for column in columns)] for name in names)]


def _told(before: PushRecord, after: PushRecord) -> dict[str, str]:
    """What to tell of a push, by name; a dash where it is not known."""
    assert after.action is not None
    (kappa, d), path, outcome = after.action.u, after.action.path, after.action.outcome
    was, now = before.view.seen, after.view.seen
    told = {
        "kappa": f"{kappa:.4f}",
        "d (mm)": f"{d * 1e3:.2f}",
        "speed (m/s)": _number(path.speed, 3),
        "moved (mm)": f"{np.linalg.norm(now.c - was.c) * 1e3:.2f}",
        "turned (deg)": f"{np.degrees(now.theta - was.theta):.2f}",
    }
    for one in (*TERMS, TOTAL):
        told[f"{one.name} error ({one.unit})"] = f"{after.errors.size(one):.{one.digits + 1}f}"
    told["change of e_T"] = f"{after.action.xi:+.4f}"
    strain = outcome.strain
    told["peak strain (%)"] = _number(None if strain is None else 100 * strain.p99_peak, 2)
    told["limit (%)"] = _number(None if strain is None or strain.limit is None else 100 * strain.limit, 2)
    told["tool force, peak (N)"] = _number(outcome.tool_force_peak, 3)
    told["tool force, mean (N)"] = _number(outcome.tool_force_mean, 3)
    return told


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
