"""Nothing grows with a run but its files: no memory, no cost of recording a push, nothing that readers need.

Time is that of the processor, since others use this machine too. docs/reliability.md has the numbers.
"""

import json
import subprocess
import sys
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.long_run import GROWTH_MB, RATIO, SETTINGS, VERBS, around
from benchmarks.many_runs import spent
from deformpush.experiment.recorder import Recorder
from deformpush.push_record import PushRecord, Timing
from deformpush.record import pictures, table
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_pictures, read_poses
from deformpush.record.settings import RECENT, RecordSettings
from deformpush.study import run_data, run_figure
from tests.record.synthetic import SyntheticRun
from tests.viewer.recording import Contents

ROOT = Path(__file__).resolve().parents[2]
MOST_MB = 400
"""For making a run of 2,000 pushes, and for each verb that looks at it."""
WATCHED = """
import json, sys, time
from benchmarks.long_run import resident_mb
from tests.experiment.test_long_runs import endless, full
recorder, (first, *rows) = full(sys.argv[1]), endless(int(sys.argv[2]))
with recorder:
    recorder.open(first.info, first.record, dict)
    memory, cost = [], []
    for row in rows:
        began = time.thread_time()
        recorder(row)
        cost.append(time.thread_time() - began)
        memory.append(resident_mb())
    recorder.close("budget", "as asked")
print(json.dumps([memory, cost]))
"""


class First:
    """Row 0 of an endless run, and what stays the same."""

    def __init__(self, made: SyntheticRun, record: PushRecord) -> None:
        self.info, self.record = made.info, record


def endless(pushes: int):
    """What stays the same, then one record after the other: the pushes of a made-up run over and over."""
    made = SyntheticRun(24, forecasts=True)
    rows = made.records()
    yield First(made, rows[0])
    for k in range(1, pushes + 1):
        row = rows[1 + (k - 1) % 24]
        yield replace(row, k=k, timing=Timing(0.02, 0.03, 2.0 * k))


def full(folder: str) -> Recorder:
    return Recorder(RunFolder.create(folder, ""), RecordSettings(figures=False))


def watched(folder: Path, pushes: int) -> tuple[np.ndarray, np.ndarray]:
    """Memory (MB) and cost (s) after each push of a recorded run, in a process of its own."""
    line = [sys.executable, "-c", WATCHED, str(folder), str(pushes)]
    done = subprocess.run(line, check=True, cwd=ROOT, capture_output=True, text=True)
    memory, cost = json.loads(done.stdout)
    assert done.stderr == ""
    return np.array(memory), np.array(cost)


@pytest.fixture(scope="module")
def long(tmp_path_factory) -> tuple[Path, np.ndarray, np.ndarray]:
    """A recorded run of 600 pushes with all there is to record."""
    folder = tmp_path_factory.mktemp("long") / "run"
    return (folder, *watched(folder, 600))


def test_recording_takes_no_more_memory_with_every_push(long):
    _, memory, _ = long
    assert memory[-50:].max() - memory[199] < GROWTH_MB * 400 / 1800


def test_recording_a_push_costs_no_more_than_at_first(long):
    _, _, cost = long
    assert around(cost, 600) < RATIO * around(cost, 100)


@pytest.fixture(scope="module")
def contents(long) -> Contents:
    return Contents(long[0] / "recording.rrd")


def test_a_long_run_is_whole(long, contents):
    folder = long[0]
    assert (
        len(read_poses(folder / "contours.npz").contours) == len(read_pictures(folder / "views.npz")) == 601
    )
    assert contents.times("/camera/image", "push") == list(range(601))
    xi = contents.curves("/xi/actual")[1:, 0]
    np.testing.assert_array_equal(xi, np.tile(xi[:24], 25), "24 pushes over and over")


def test_marks_in_the_recording_go_back_so_far_and_no_further(contents):
    trail = {k: strips[0] for k, strips in contents.at("/camera/trail", "LineStrips2D:strips").items()}
    marks = contents.at("/model/data", "Points2D:positions")
    assert [len(trail[k]) for k in (0, 1, 50)] == [1, 2, 51]
    assert {len(strip) for k, strip in trail.items() if k >= RECENT} == {RECENT + 1}
    assert {len(points) for k, points in marks.items() if k >= RECENT} == {RECENT}
    assert trail[600][:-1] == trail[599][1:]


def test_what_is_made_again_is_not_kept_with_its_pictures(tmp_path):
    """A run that is taken up again makes all its pushes again before anything is written."""
    first, *rows = endless(300)
    recorder = full(str(tmp_path / "run"))
    tracemalloc.start()
    for row in [first.record, *rows]:
        picture = row.view.picture.copy()
        recorder.remember(replace(row, view=replace(row.view, picture=picture)))
    kept = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert kept < 300 * 15_000 + 2 * picture.nbytes


def test_the_figure_of_a_long_run_decodes_four_pictures(long, monkeypatch):
    decoded, whole = [], pictures.decode

    def counted(picture: bytes) -> np.ndarray:
        decoded.append(picture)
        return whole(picture)

    monkeypatch.setattr(pictures, "decode", counted)
    run_figure.draw(RunFolder(long[0]))
    assert len(decoded) == 4


def test_the_figure_of_a_long_run_has_a_panel_for_each_action(long):
    """Marks for kappa, d and xi in one panel would hide one another."""
    folder = RunFolder(long[0])
    actions = run_figure.figure(run_data.read(folder)).axes[5:]
    columns = table.columns(folder.table)
    assert [axis.get_ylabel() for axis in actions] == [r"$\kappa$ (-)", "$d$ (mm)", r"$\xi$ (-)"]
    for axis, name, scale in zip(actions, ("kappa", "d", "xi"), (1, 1e3, 1), strict=True):
        (dots,) = [line for line in axis.lines if line.get_marker() == "."]
        np.testing.assert_array_equal(dots.get_xdata(), range(1, 601))
        np.testing.assert_allclose(dots.get_ydata(), scale * np.asarray(columns[name][1:], float))
        assert axis.get_ylim()[0] <= dots.get_ydata().min() <= dots.get_ydata().max() <= axis.get_ylim()[1]
    places = [axis.get_position() for axis in actions]
    assert places[0].y0 > places[1].y1 > places[1].y0 > places[2].y1


@pytest.mark.slow
def test_recording_two_thousand_pushes(tmp_path):
    memory, cost = watched(tmp_path / "run", 2000)
    assert memory[-50:].max() - memory[199] < GROWTH_MB
    assert around(cost, 2000) < RATIO * around(cost, 100)


@pytest.mark.slow
def test_a_run_of_two_thousand_pushes_and_what_becomes_of_it(tmp_path):
    """Made, compared, reported, filmed."""
    folder, scratch = tmp_path / "run", tmp_path / "scratch"
    settings = [*SETTINGS, "optimizer=random", "max_pushes=2000", f"hydra.run.dir={folder}"]
    assert spent(settings).peak_mb < MOST_MB
    for verb, words in VERBS.items():
        took = spent([verb, str(folder), *(word.format(scratch=scratch) for word in words)])
        assert took.peak_mb < MOST_MB, verb
    assert json.loads((folder / "summary.json").read_text())["pushes"] == 2000
    assert {path.name for path in scratch.iterdir()} == {"compare", "report.html", "video.mp4"}
