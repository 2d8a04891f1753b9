"""The recorder leaves a complete folder however the run ends."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from deformpush.experiment.recorder import Recorder
from deformpush.record import checkpoint, unfinished
from deformpush.record.folder import FolderError, RunFolder
from deformpush.record.poses import read_poses, read_views
from deformpush.record.settings import RecordSettings
from deformpush.record.table import read, read_rows
from deformpush.task import ERROR_COLUMNS
from tests.record.synthetic import SyntheticRun
from tests.viewer.recording import Contents

KEPT = ("kappa", "d", "e_T", "strain_p99_peak", "steps", "step_s", "render_s", "decide_s")
"""Columns that are the same whether a run was interrupted or not."""


def off(path) -> Recorder:
    return Recorder(RunFolder.create(path, "seed: 0\n"), RecordSettings(rrd=False, figures=False))


def test_summary_of_a_finished_run(tmp_path, run):
    info, rows = run
    with off(tmp_path) as recorder:
        spent = recorder.open(info, rows[0], dict) + sum(recorder(row) for row in rows[1:])
        summary = recorder.close("reached", "all errors at or under their stops", wall_s=12.5)
    found = json.loads((tmp_path / "summary.json").read_text())
    assert found == summary.flat()
    assert (found["status"], found["pushes"], found["wall_s"]) == ("reached", 14, 12.5)
    assert found["record_s"] == pytest.approx(spent)
    assert found["steps"] == 14 * 480
    assert found["step_s"] == pytest.approx(sum(row.action.outcome.step_s for row in rows[1:]))
    assert {name: found[name] for name in ERROR_COLUMNS} == rows[-1].errors.values
    assert (found["object"], found["model"], found["acquisition"]) == ("rect", "error", "lcb")
    assert (found["seed"], found["initial_samples"]) == (0, 10)
    assert sum(read(tmp_path / "pushes.csv")["record_s"]) < found["record_s"]


def test_the_strain_of_a_run_is_summed_up(tmp_path, run):
    info, rows = run
    with off(tmp_path) as recorder:
        recorder.open(info, rows[0], dict)
        for row in rows[1:]:
            recorder(row)
        summary = recorder.close("budget", "as asked")
    peaks = [row.action.outcome.strain.p99_peak for row in rows[1:]]
    assert summary.strain_limit == info.strain_limit
    assert summary.strain_peak == max(peaks)
    assert summary.strain_dose == pytest.approx(sum(peaks))
    assert summary.exceedances == sum(peak > info.strain_limit for peak in peaks) > 0


def test_what_the_optimizer_knows_is_asked_for_after_each_push(tmp_path, run):
    info, rows = run
    asked = []

    def knows():
        asked.append(len(read_rows(tmp_path / "pushes.csv")))
        return {"asked": len(asked), "U": np.eye(2)}

    with off(tmp_path) as recorder:
        recorder.open(info, rows[0], knows)
        assert not (tmp_path / "checkpoint.npz").exists()
        for row in rows[1:4]:
            recorder(row)
        recorder.close("budget", "as asked")
    assert asked == [2, 3, 4], "the checkpoint is never ahead of the table"
    found = checkpoint.read(tmp_path / "checkpoint.npz")
    assert (found.k, found.state["asked"]) == (3, 3)


@pytest.mark.parametrize(
    ("error", "status", "reason"),
    [
        (KeyboardInterrupt(), "interrupted", "interrupted from the keyboard (Ctrl-C)"),
        (OSError(28, "No space left on device"), "interrupted", "No space left on device"),
        (RuntimeError("boom"), "failed", "RuntimeError: boom"),
    ],
)
def test_a_run_that_breaks_off_keeps_its_pushes_and_says_why(tmp_path, run, error, status, reason):
    info, rows = run

    def break_off() -> None:
        with off(tmp_path) as recorder:
            recorder.open(info, rows[0], dict)
            recorder(rows[1])
            raise error

    with pytest.raises(type(error)):
        break_off()
    found = json.loads((tmp_path / "summary.json").read_text())
    assert (found["status"], found["reason"], found["pushes"]) == (status, reason, 1)
    assert len(read(tmp_path / "pushes.csv")) == len(read_poses(tmp_path / "contours.npz").contours) == 2


def test_a_run_left_without_an_end_has_failed(tmp_path, run):
    with off(tmp_path) as recorder:
        recorder.open(run[0], run[1][0], dict)
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "failed"


def test_an_error_before_the_first_state_leaves_no_summary(tmp_path):
    with pytest.raises(RuntimeError), off(tmp_path):
        raise RuntimeError
    assert not (tmp_path / "summary.json").exists()


def test_the_folder_is_held_until_the_end(tmp_path, run):
    folder = RunFolder(tmp_path)
    with off(tmp_path) as recorder:
        recorder.open(run[0], run[1][0], dict)
        with pytest.raises(FolderError, match="another process is at work"):
            folder.lock()
        recorder.close("budget", "as asked")
        folder.lock().release()


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_run_taken_up_again_ends_as_if_it_had_never_stopped(tmp_path):
    made = SyntheticRun(13, forecasts=True)
    rows, settings = made.records(), RecordSettings(figures=False)
    whole, halves = (RunFolder.create(tmp_path / name, "") for name in ("whole", "halves"))
    with Recorder(whole, settings) as recorder:
        recorder.open(made.info, rows[0], dict)
        for row in rows[1:]:
            recorder(row)
        once = recorder.close("reached", "all errors")
    with pytest.raises(KeyboardInterrupt), Recorder(halves, settings) as recorder:
        interrupt_after(recorder, made, rows[:12])
    left = unfinished.read(halves)
    with Recorder(halves, settings) as recorder:
        for row in rows[:12]:
            recorder.remember(row)
        recorder.reopen(made.info, left, dict, halves.lock())
        assert not halves.summary.exists()
        for row in rows[12:]:
            recorder(row)
        twice = recorder.close("reached", "all errors")
    tables = [read(folder.table)[list(KEPT)] for folder in (whole, halves)]
    assert tables[0].equals(tables[1])
    assert (twice.resumed, twice.pushes) == (11, 13)
    totals = ("steps", "strain_dose", "strain_peak", "exceedances", "step_s", "decide_s")
    for name in ("errors", "calibration", *totals):
        assert getattr(twice, name) == pytest.approx(getattr(once, name))
    one, two = (read_poses(folder.contours) for folder in (whole, halves))
    np.testing.assert_array_equal(one.contours, two.contours)
    np.testing.assert_array_equal(one.starts, two.starts)
    np.testing.assert_array_equal(*(read_views(folder.views) for folder in (whole, halves)))
    forecasts = [(folder.path / "forecasts.csv").read_bytes() for folder in (whole, halves)]
    assert forecasts[0] == forecasts[1]
    recordings = [Contents(folder.recording) for folder in (whole, halves)]
    assert not (halves.path / "recording-2.rrd").exists()
    for entity in ("/errors/position", "/xi/predicted", "/motion/moved/predicted", "/strain"):
        first, second = (contents.at(entity, "Scalars:scalars") for contents in recordings)
        assert first.keys() == second.keys()
        for k, values in first.items():
            np.testing.assert_array_equal(values, second[k])


def interrupt_after(recorder: Recorder, made: SyntheticRun, rows: list) -> None:
    recorder.open(made.info, rows[0], dict)
    for row in rows[1:]:
        recorder(row)
    raise KeyboardInterrupt


FOURTH = """
import sys
from dataclasses import replace
from deformpush import task
tilt = replace(
    task.TERMS[0], name="tilt", symbol="e_tilt", tex="$e_t$", unit="deg", column="tilt_rad",
    scale=180 / 3.14159265, colour=(1, 2, 3),
)
task.TERMS = (*task.TERMS, tilt)
task.ERROR_COLUMNS = (
    *(term.symbol for term in task.TERMS), "e_T",
    *(term.column for term in task.TERMS if term.column != term.symbol),
)
from pathlib import Path
from tests.record.synthetic import SyntheticRun
from tests.viewer.recording import record
record(Path(sys.argv[1]), SyntheticRun(2, mesh=False), scene=False)
"""


def test_an_error_term_more_is_recorded_everywhere(tmp_path):
    """Where the table of errors has one more, with no other edit. The made-up run gives it 0.25."""
    root, folder = Path(__file__).parents[2], RunFolder(tmp_path / "run")
    subprocess.run([sys.executable, "-c", FOURTH, str(folder.path)], check=True, cwd=root)
    assert [(row["e_tilt"], row["tilt_rad"]) for row in read_rows(folder.table)] == [(0.25, 0.25)] * 3
    summary = json.loads(folder.summary.read_text())
    order = list(summary)
    assert order.index("e_gamma") < order.index("e_tilt") < order.index("e_T") < order.index("tilt_rad")
    assert len(read_poses(folder.contours).stops) == 4
    contents = Contents(folder.recording)
    np.testing.assert_allclose(contents.curves("/errors/tilt")[:, 0], np.degrees(0.25))
    assert contents.titles("/errors/tilt") == ["tilt (deg)", "stop"]
    assert contents.colours("/errors/tilt", "SeriesLines:colors")[0] == (1, 2, 3)
    assert contents.view("Tilt error (deg)").origin == "errors/tilt"
    assert "[tilt](recording://errors/tilt) (e_tilt)" in contents.fixed("/about", "TextDocument:text")[0]
    assert "| tilt | 14.3 deg |" in contents.at("/now", "TextDocument:text")[2][0]
