"""compare.rrd of one push made in two ways: the bottom views side by side, the errors over each other."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from deformpush.record import palette, table
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_pictures, read_poses
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
