"""Nothing grows with a run but its files: no memory, no cost of recording a push, nothing that readers need.

Time is that of the processor, since others use this machine too. docs/reliability.md has the numbers.
"""

import json
import os
import re
import resource
import subprocess
import sys
import tracemalloc
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.long_run import SETTINGS, VERBS, resident_mb
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.recorder import Recorder
from deformpush.experiment.run import make_run
from deformpush.push_record import PushRecord, Timing
from deformpush.record import pictures
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_pictures, read_poses
from deformpush.record.settings import RECENT, RecordSettings
from deformpush.study import run_figure
from tests.record.synthetic import SyntheticRun
from tests.setups import setup
from tests.viewer.recording import Contents

ROOT = Path(__file__).resolve().parents[2]
GROWTH_MB, RATIO = 20, 1.5
"""At most, of the memory from push 200 on, and of the cost of a push since push 100."""
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


def around(values: np.ndarray, k: int) -> float:
    return float(np.median(values[max(0, k - 50) : k + 50]))


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


@pytest.mark.slow
def test_recording_two_thousand_pushes(tmp_path):
    memory, cost = watched(tmp_path / "run", 2000)
    assert memory[-50:].max() - memory[199] < GROWTH_MB
    assert around(cost, 2000) < RATIO * around(cost, 100)


@pytest.mark.slow
def test_a_run_of_two_thousand_pushes_and_what_becomes_of_it(tmp_path):
    """Made, compared, reported, filmed; none of it needs more than 400 MB."""
    folder, scratch = tmp_path / "run", tmp_path / "scratch"
    settings = [*SETTINGS, "optimizer=random", "max_pushes=2000", f"hydra.run.dir={folder}"]
    assert spent([], settings)[1] < 400
    for verb, words in VERBS.items():
        _, peak_mb = spent([verb, str(folder)], [word.format(scratch=scratch) for word in words])
        assert peak_mb < 400, verb
    assert json.loads((folder / "summary.json").read_text())["pushes"] == 2000
    assert {path.name for path in scratch.iterdir()} == {"compare", "report.html", "video.mp4"}


def spent(head: list[str], settings: list[str]) -> tuple[float, float]:
    """Carry out a command; seconds of the processor, and most memory (MB)."""
    line = [sys.executable, "-m", "deformpush", *head, *settings]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    with subprocess.Popen(line, stdout=subprocess.DEVNULL, env=environment) as process:
        _, code, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(code)
    assert process.returncode == 0, line
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e3


@pytest.fixture(scope="module")
def sweep(tmp_path_factory) -> Path:
    """The folder of 10,000 finished toy runs, which differ in their seed."""
    root = tmp_path_factory.mktemp("large") / "sweep"
    made = root / "seed=0"
    make_run(setup("world=toy", "robot=tool", "record=off", "max_pushes=20", "seed=0"), made)
    config, summary = (made / "config.yaml").read_text(), (made / "summary.json").read_text()
    same = ("provenance.json", "pushes.csv", "contours.npz", "views.npz", ".lock")
    for seed in range(1, 10_000):
        run = root / f"seed={seed}"
        run.mkdir()
        (run / "config.yaml").write_text(re.sub(r"(?m)^seed: 0$", f"seed: {seed}", config))
        (run / "summary.json").write_text(summary.replace('"seed": 0', f'"seed": {seed}'))
        for name in same:
            os.link(made / name, run / name)
    jobs = [{"name": f"seed={seed}", "overrides": [f"seed={seed}"]} for seed in range(10_000)]
    (root / "sweep.json").write_text(json.dumps({"command": "", "jobs": jobs}))
    return root


@pytest.mark.slow
def test_a_sweep_of_ten_thousand_runs_has_its_status_in_five_seconds(sweep):
    assert spent(["status", str(sweep)], [])[0] < 5
    assert (sweep / "sweep.csv").read_text().count("\n") == 10_001


@pytest.mark.slow
def test_a_sweep_of_ten_thousand_runs_is_compared_in_a_minute(sweep, tmp_path):
    seconds, peak_mb = spent(["compare", str(sweep)], ["--out", str(tmp_path)])
    assert seconds < 60
    assert peak_mb < 1000
    assert (tmp_path / "compare.csv").read_text().count("\n") == 10_001


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("robot", ["tool", "kuka_iiwa"])
def test_three_hundred_worlds_leave_nothing_behind(robot):
    made = setup(f"robot={robot}")
    for n in range(300):
        cell = build_cell(made)
        with closing(cell.world):
            cell.look(None)
        if n == 50:
            before = resident_mb(), open_files()
    assert resident_mb() - before[0] < 5
    assert open_files() == before[1]
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3 < before[0] + 50


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))
