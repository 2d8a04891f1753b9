"""The folder of a run as a kill after each of its pushes leaves it, and what must be alike in two folders."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from deformpush.experiment.recorder import Recorder
from deformpush.experiment.run import make_run
from deformpush.experiment.setup import Setup
from deformpush.record.poses import read_pictures, read_poses
from deformpush.record.table import TIMES, read

TOLD = ("status", "reason", "pushes", "e_T", "steps", "strain_dose")


def with_snapshots(made: Setup, folder: Path) -> Path:
    """Make a run; beside it `at-K` for each push K."""
    whole = Recorder.__call__

    def copied(self, record):
        seconds = whole(self, record)
        shutil.copytree(folder, folder.with_name(f"at-{record.k}"))
        return seconds

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Recorder, "__call__", copied)
        make_run(made, folder)
    return folder


def taken(whole: Path, pushes: int, to: Path) -> Path:
    """A copy of the folder that a kill after so many pushes leaves."""
    shutil.copytree(whole.with_name(f"at-{pushes}"), to)
    return to


def alike(folder: Path, other: Path) -> None:
    """The two runs made the same pushes with the same outcomes, to the bit, and kept the same of them."""
    a, b = (read(path / "pushes.csv").drop(columns=list(TIMES)) for path in (folder, other))
    assert a.equals(b)
    one, two = (read_poses(path / "contours.npz") for path in (folder, other))
    for name in ("contours", "centroids", "thetas", "starts", "ends"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert read_pictures(folder / "views.npz") == read_pictures(other / "views.npz")
    assert (folder / "world_states.bin").read_bytes() == (other / "world_states.bin").read_bytes()
    ends = [json.loads((path / "summary.json").read_text()) for path in (folder, other)]
    assert [ends[0][name] for name in TOLD] == [ends[1][name] for name in TOLD]
