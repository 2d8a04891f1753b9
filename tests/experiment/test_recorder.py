"""The recorder leaves a complete folder however the run ends."""

import json
from dataclasses import fields

import pytest

from deformpush.experiment.recorder import Recorder
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_trace
from deformpush.record.summary import Strains, Summary, strains
from deformpush.record.table import read


def off(path) -> Recorder:
    return Recorder(RunFolder.create(path, "seed: 0\n"), rrd=False, figures=False)


def test_summary_of_a_finished_run(tmp_path, run):
    info, rows = run
    with off(tmp_path) as recorder:
        spent = recorder.open(info, rows[0]) + sum(recorder.push(row) for row in rows[1:])
        recorder.close("reached", "all errors at or under their stops", wall_s=12.5)
    found = json.loads((tmp_path / "summary.json").read_text())
    assert list(found) == [item.name for item in fields(Summary)]
    assert (found["status"], found["pushes"], found["wall_s"]) == ("reached", 14, 12.5)
    assert found["record_s"] == pytest.approx(spent)
    assert found["steps"] == 14 * 480
    assert found["step_s"] == pytest.approx(sum(row.step_s for row in rows))
    assert found["e_T"] == rows[-1].e_T
    assert sum(read(tmp_path / "pushes.csv")["record_s"]) < found["record_s"]


def test_the_strain_of_a_run_is_summed_up(tmp_path, run):
    info, rows = run
    with off(tmp_path) as recorder:
        recorder.open(info, rows[0])
        for row in rows[1:]:
            recorder.push(row)
        summary = recorder.close("budget", "as asked")
    peaks = [row.strain.p99_peak for row in rows[1:]]
    assert summary.strain_limit == info.strain_limit
    assert summary.strain_peak == max(peaks)
    assert summary.strain_dose == pytest.approx(sum(peaks))
    assert summary.exceedances == sum(peak > info.strain_limit for peak in peaks) > 0


def test_without_strain_or_without_a_limit_nothing_is_made_up():
    assert strains([], 0.1) == Strains(None, None, None)
    assert strains([0.05, 0.2], None) == Strains(0.2, None, 0.25)
    assert strains([0.05, 0.1], 0.1) == Strains(0.1, 0, pytest.approx(0.15)), "the limit itself is allowed"


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
            recorder.open(info, rows[0])
            recorder.push(rows[1])
            raise error

    with pytest.raises(type(error)):
        break_off()
    found = json.loads((tmp_path / "summary.json").read_text())
    assert (found["status"], found["reason"], found["pushes"]) == (status, reason, 1)
    assert len(read(tmp_path / "pushes.csv")) == len(read_trace(tmp_path / "contours.npz").contours) == 2


def test_an_error_before_the_first_state_leaves_no_summary(tmp_path):
    with pytest.raises(RuntimeError), off(tmp_path):
        raise RuntimeError
    assert not (tmp_path / "summary.json").exists()
