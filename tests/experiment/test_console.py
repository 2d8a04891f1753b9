"""What a run says on the terminal; that signals end it in good order is tested in test_resume."""

import io
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deformpush.experiment.console import Progress, Verbosity, closing_lines, say
from deformpush.record.summary import Summary
from deformpush.task import ERROR_COLUMNS, Errors
from tests.record.synthetic import SyntheticRun

ERRORS = {
    "e_c": 0.09,
    "e_theta": -0.02,
    "e_gamma": 0.123,
    "e_T": 0.4,
    "position_error_m": 0.0184,
    "angle_error_rad": float(np.radians(-3.62)),
}
SUMMARY = Summary(
    status="reached",
    reason="all errors at or under their stop values",
    pushes=17,
    initial_samples=10,
    seed=0,
    object="rect",
    model="error",
    acquisition="lcb",
    errors={column: ERRORS[column] for column in ERROR_COLUMNS},
    wall_s=61.4,
    step_s=48.6,
    render_s=1.0,
    decide_s=2.0,
    record_s=3.0,
    steps=6000,
)
START, AFTER, *_ = [
    replace(record, errors=Errors(ERRORS | {"position_error_m": 0.2 / (record.k + 1)}))
    for record in SyntheticRun(3).records()
]


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_run_that_reached_the_goal(tmp_path):
    assert closing_lines(SUMMARY, tmp_path).split("\n") == [
        "reached: reached the goal after 17 pushes",
        "errors:    position 18.4 mm, angle 3.6 deg, shape 0.123",
        "time:      61 s, of which 49 s in the simulator",
        f"folder:    {tmp_path}",
    ]


@pytest.mark.parametrize(
    ("status", "pushes", "reason", "line"),
    [
        (
            "budget",
            80,
            "the budget is spent",
            "budget: did not reach the goal after 80 pushes (the budget is spent)",
        ),
        ("failed", 1, "it exploded", "failed: failed after 1 push (it exploded)"),
        ("failed", 0, "it exploded", "failed: failed after 0 pushes (it exploded)"),
    ],
)
def test_other_ends_say_why(status, pushes, reason, line):
    summary = replace(SUMMARY, status=status, pushes=pushes, reason=reason)
    assert closing_lines(summary, Path("x")).split("\n")[0] == line


@pytest.mark.parametrize(
    ("limit", "exceedances", "line"),
    [
        (0.1, 4, "strain:    13.2% at most (p99 of the volume), 4 of 17 pushes beyond the limit of 10%"),
        (None, None, "strain:    13.2% at most (p99 of the volume; no limit is given)"),
    ],
)
def test_a_run_that_measured_strain_says_so(limit, exceedances, line, tmp_path):
    summary = replace(SUMMARY, strain_peak=0.1322, strain_limit=limit, exceedances=exceedances)
    assert closing_lines(summary, tmp_path).split("\n")[2] == line


def test_the_recording_is_named_as_the_shell_wants_it(tmp_path):
    folder = tmp_path / "my runs"
    folder.mkdir()
    (folder / "recording.rrd").touch()
    assert closing_lines(SUMMARY, folder).endswith(f"\nrecording: rerun '{folder}/recording.rrd'")


@pytest.mark.parametrize(
    ("verbosity", "lines"),
    [
        (Verbosity.FULL, 4),
        (Verbosity.ONE_LINE, 1),
        (Verbosity.NO_BAR, 1),
        (Verbosity.BAR_ONLY, 0),
        (Verbosity.SILENT, 0),
    ],
)
def test_how_it_ended_is_said_as_fully_as_asked(tmp_path, capsys, verbosity, lines):
    say(SUMMARY, tmp_path / "run", verbosity)
    told = capsys.readouterr().out.splitlines()
    assert len(told) == lines
    if lines == 1:
        assert told == ["run: reached after 17 pushes, 61 s"]


@pytest.mark.parametrize("verbosity", Verbosity)
def test_progress_on_a_terminal(monkeypatch, verbosity):
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    with Progress(5, verbosity) as show:
        show(START)
        show(AFTER)
    told = terminal.getvalue()
    if verbosity in (Verbosity.NO_BAR, Verbosity.SILENT):
        assert told == ""
        return
    assert "start: position 200.0 mm, angle 3.6 deg, shape 0.123" in told
    last = next(part for part in reversed(told.split("\r")) if part.strip())
    assert "pushes 1/5" in last
    assert "initial: position 100.0 mm, angle 3.6 deg, shape 0.123" in last
    assert told.endswith("\n") == (verbosity is Verbosity.FULL), "one of many leaves nothing on the screen"


def test_no_progress_where_no_one_watches(monkeypatch):
    monkeypatch.setattr(sys, "stderr", pipe := io.StringIO())
    with Progress(5) as show:
        show(START)
    assert pipe.getvalue() == ""


def test_a_run_with_forecasts_says_how_good_they_were(tmp_path):
    lines = closing_lines(replace(SUMMARY, calibration=0.934), tmp_path).split("\n")
    assert lines[2] == "forecasts: 93% of outcomes inside their 95% intervals"
    assert len(lines) == 5
