"""summary.json keeps its keys and their order, and says what the pushes add up to."""

import json
import os
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from deformpush.record import finished
from deformpush.record.finished import NotFinishedError
from deformpush.record.folder import RunFolder
from deformpush.record.status import run_status
from deformpush.record.summary import Summary, Totals, read, write
from deformpush.record.table import cells
from deformpush.task import ERROR_COLUMNS

KEYS = (
    *("status", "reason", "pushes", "initial_samples", "seed", "object", "model", "acquisition"),
    *("e_c", "e_theta", "e_gamma", "e_T", "position_error_m", "angle_error_rad"),
    *("wall_s", "step_s", "render_s", "decide_s", "record_s", "steps", "calibration", "resumed"),
    *("strain_limit", "strain_peak", "exceedances", "strain_dose", "force_limit", "force_peak"),
)
"""What 0.1 wrote, then the force."""
SUMMARY = Summary(
    status="reached", reason="all errors", pushes=3, initial_samples=2, seed=4, object="rect", model="error",
    acquisition="lcb", errors={name: 0.5 + i for i, name in enumerate(ERROR_COLUMNS)}, wall_s=9.0, step_s=1.0,
    render_s=2.0, decide_s=3.0, record_s=4.0, steps=5, strain_limit=0.1,
)  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    folder = RunFolder(tmp_path)
    write(folder, SUMMARY)
    return folder


def test_keys_are_flat_and_in_order(folder):
    found = json.loads(folder.summary.read_text())
    assert tuple(found) == KEYS
    assert (found["e_c"], found["e_T"], found["angle_error_rad"]) == (0.5, 3.5, 5.5)
    assert list(SUMMARY.flat().items()) == list(found.items())


def test_what_was_written_is_read(folder):
    assert read(folder) == SUMMARY


def test_numbers_that_are_not_finite_come_back_as_nan(folder):
    write(folder, replace(SUMMARY, wall_s=np.inf, errors={**SUMMARY.errors, "e_c": np.nan}))
    found = read(folder)
    assert np.isnan([found.wall_s, found.errors["e_c"]]).all()
    assert found.calibration is None, "and what a run has not is none"


def test_an_error_that_another_version_did_not_know_is_nan(folder):
    told = json.loads(folder.summary.read_text())
    del told["e_gamma"]
    folder.summary.write_text(json.dumps(told))
    found = read(folder)
    assert list(found.errors) == list(ERROR_COLUMNS)
    assert np.isnan(found.errors["e_gamma"])
    assert found.errors["e_T"] == 3.5


@pytest.mark.parametrize(
    ("change", "differs"),
    [
        ({"mood": 1}, "mood"),
        ({"errors": {}}, "errors"),
        ({"seed": ...}, "seed"),
        ({"e_T": ...}, "e_T"),
        ({"zeal": 1, "mood": 1, "anger": 1, "seed": ...}, "anger, mood, seed"),
    ],
)
def test_another_version_is_named(folder, change, differs):
    told = json.loads(folder.summary.read_text()) | change
    folder.summary.write_text(json.dumps({key: value for key, value in told.items() if value is not ...}))
    with pytest.raises(ValueError, match=rf"^summary\.json is of another version \(differs in {differs}\)$"):
        read(folder)


@pytest.mark.parametrize("text", ["", "{", "[1]", "3", "null", '"text"', "\xff"])
def test_a_damaged_file_is_refused(folder, text):
    folder.summary.write_bytes(text.encode("latin-1"))
    with pytest.raises(ValueError, match=r"^summary\.json is damaged: (not JSON|no keys in it)$"):
        read(folder)
    folder.summary.unlink()
    with pytest.raises(FileNotFoundError):
        read(folder)


def test_rows_add_up_whether_written_or_read(run):
    totals, rows = Totals(), run[1]
    for row in rows:
        totals.add(cells(row, 0.25))
    assert totals.seconds == pytest.approx(
        {"step_s": 14 * 0.9, "render_s": 15 * 0.02, "decide_s": 15 * 0.03, "record_s": 15 * 0.25}
    )
    assert totals.steps == 14 * 480
    assert totals.strains == [row.action.outcome.strain.p99_peak for row in rows[1:]]
    totals.add(EMPTY | {"strain_p99_peak": np.nan})
    assert len(totals.strains) == 14


EMPTY = {"step_s": 0.0, "render_s": 0.0, "decide_s": 0.0, "record_s": 0.0, "steps": 0}
EMPTY |= dict.fromkeys(("strain_p99_peak", "tool_force_peak", "limit_exceeded"))


def test_what_is_not_measured_or_has_no_limit_is_not_made_up():
    totals = Totals()
    totals.add(EMPTY)
    assert (totals.strains, totals.strain_dose, totals.forces, totals.exceedances) == ([], None, [], None)
    totals.add(EMPTY | {"strain_p99_peak": 0.05})
    totals.add(EMPTY | {"strain_p99_peak": 0.2, "tool_force_peak": 3.0})
    assert (totals.strain_dose, totals.forces, totals.exceedances) == (0.25, [3.0], None)


def test_pushes_beyond_a_limit_are_counted():
    totals = Totals()
    totals.add(EMPTY | {"limit_exceeded": False})
    assert totals.exceedances == 0
    totals.add(EMPTY | {"limit_exceeded": 1.0})
    totals.add(EMPTY | {"limit_exceeded": np.nan})
    assert totals.exceedances == 1


ANYTHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=5,
)


def allowed(key: str, value: object) -> bool:
    """Whether summary.json may say so."""
    whole, number = isinstance(value, int) and not isinstance(value, bool), isinstance(value, int | float)
    if key == "status":
        return value in ("reached", "budget", "damaged", "failed", "interrupted")
    if key in ("reason", "object", "model", "acquisition"):
        return isinstance(value, str)
    if key in ("pushes", "initial_samples", "seed", "steps"):
        return whole and value >= 0
    if key in ("resumed", "exceedances"):
        return value is None or (whole and value >= 0)
    return value is None or (number and not isinstance(value, bool))


@pytest.mark.parametrize("key", KEYS)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(value=ANYTHING)
def test_a_value_of_the_wrong_type_is_one_line(key, value, folder):
    found = SUMMARY.flat() | {key: value}
    folder.summary.write_text(json.dumps(found))
    if allowed(key, value):
        assert read(folder).flat().keys() == SUMMARY.flat().keys()
        assert run_status(folder).summary[key] == value
        return
    for said in (refusal(folder), run_status(folder).text):
        assert re.match(rf"summary\.json is damaged: {key}[.\d]* = ", said)
        assert "\n" not in said
    assert run_status(folder).state == "interrupted"
    with pytest.raises(NotFinishedError, match=f"damaged: {key}"):
        finished.read(folder, "run")


def refusal(folder: RunFolder) -> str:
    with pytest.raises(ValueError, match="damaged") as caught:
        read(folder)
    return str(caught.value)


def test_a_pipe_in_place_of_it_is_one_line(folder):
    folder.summary.unlink()
    os.mkfifo(folder.summary)
    with pytest.raises(ValueError, match=r"^summary\.json cannot be read \(no regular file\)$"):
        read(folder)
    assert run_status(folder).text == "summary.json cannot be read (no regular file)"
