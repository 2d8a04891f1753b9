"""Tables of runs and variants: every cell, for people and for programs."""

import csv
from statistics import median

import pytest

from deformpush.study.find_runs import find_runs
from deformpush.study.tables import (
    CAPTION,
    UNHARMED,
    caption,
    error_cells,
    is_number,
    markdown,
    run_rows,
    table_csv,
    terminal,
    variant_rows,
)  # fmt: skip
from deformpush.study.variants import differing, variants
from tests.study.folders import finished, numbers

NAMES = [f"acq.w={w},seed={seed}" for w in (1, 2) for seed in (0, 1)]


@pytest.fixture(scope="module")
def runs(sweep):
    return find_runs([sweep]).runs


@pytest.fixture(scope="module")
def differences(runs):
    return differing(runs)


def last_errors(folder) -> list[float]:
    """The errors that the run ended with, as people read them."""
    position, angle = (numbers(folder, name)[-1] for name in ("position_error_m", "angle_error_rad"))
    shape, total = (numbers(folder, name)[-1] for name in ("e_gamma", "e_T"))
    return [1e3 * position, abs(angle) * 180 / 3.141592653589793, shape, total]


def in_digits(errors) -> list[str]:
    return [f"{value:.{digits}f}" for value, digits in zip(errors, (1, 1, 3, 3), strict=True)]


def test_a_row_of_a_run_has_its_settings_its_end_and_its_errors(sweep, runs, differences):
    header, *rows = run_rows(runs, differences)
    errors = ["position (mm)", "angle (deg)", "shape (-)", "e_T"]
    ends = ["status", "pushes", "harmful"]
    first = ["object", "model", "acquisition", "seed", "acq.w"]
    assert header == [*first, *ends, *errors, "time (s)", "simulator (s)", "run"]
    made = [("reached", 12), ("budget", 15), ("reached", 4), ("reached", 11)]
    for row, name, (status, pushes) in zip(rows, NAMES, made, strict=True):
        _, w, seed = name.replace(",seed", "").split("=")
        harmful = sum(peak > 0.1 for peak in numbers(sweep / name, "strain_p99_peak"))
        simulator = sum(numbers(sweep / name, "step_s"))
        assert row[:5] == ["rect", "error", "lcb", seed, w]
        assert row[5:8] == [status, str(pushes), str(harmful)]
        assert row[8:12] == in_digits(last_errors(sweep / name))
        assert row[12:] == ["1.5", f"{simulator:.1f}", name]


def test_a_row_of_a_variant_has_counts_and_medians(sweep, runs, differences):
    header, *rows = variant_rows(variants(runs, differences))
    errors = ["position (mm)", "angle (deg)", "shape (-)", "e_T"]
    counts = ["variant", "runs", "reached", "unharmed", "pushes, reached", "pushes, all runs"]
    assert header == [*counts, *errors, "time (s)"]
    harmless = [all(not peak > 0.1 for peak in numbers(sweep / name, "strain_p99_peak")) for name in NAMES]
    assert [row[:3] for row in rows] == [["acq.w 1", "2", "1"], ["acq.w 2", "2", "2"]]
    assert [row[3] for row in rows] == [str(int(harmless[0])), str(sum(harmless[2:]))]
    assert [row[4:6] for row in rows] == [["12", "13.5 (12 to 15)"], ["7.5 (4 to 11)", "7.5 (4 to 11)"]]
    for row, names in zip(rows, (NAMES[:2], NAMES[2:]), strict=True):
        both = zip(*(last_errors(sweep / name) for name in names), strict=True)
        assert row[6:] == [*in_digits(map(median, both)), "1.5"]


def test_a_variant_that_never_arrived_has_a_dash(tmp_path):
    runs = find_runs([finished(tmp_path / "run", 2, status="budget")]).runs
    _, row = variant_rows(variants(runs, {}))
    assert row[4:6] == ["-", "2"]


def test_what_the_counts_mean_is_said(runs, differences):
    assert caption(variants(runs, differences)) == f"{CAPTION} {UNHARMED}"
    assert "median" in CAPTION
    assert "limit" in UNHARMED


def test_a_terminal_shows_as_many_settings_as_fit(runs, differences):
    assert "acq.w" not in run_rows(runs, differences, keys=0)[0]
    rows = run_rows(runs, differences)
    lines = terminal(rows).splitlines()
    assert len(lines) == 5
    assert {line.index("acq.w=") for line in lines[1:]} == {lines[0].index("run")}
    end = lines[0].index("pushes") + len("pushes")
    assert [line[:end].split()[-1] for line in lines[1:]] == ["12", "15", "4", "11"], "numbers to the right"


def test_the_file_has_every_number_of_the_summaries(runs, differences):
    rows = list(csv.DictReader(table_csv(runs, differences).splitlines()))
    assert [row["run"] for row in rows] == NAMES
    assert [row["acq.w"] for row in rows] == ["1", "1", "2", "2"]
    for row, run in zip(rows, runs, strict=True):
        told = {key: "" if value is None else str(value) for key, value in run.summary.flat().items()}
        assert {"status", "e_c", "e_theta", "e_gamma", "e_T", "position_error_m", "wall_s"} < set(told)
        assert row == {"run": run.name, "commit": run.commit, "acq.w": row["acq.w"], **told}


def test_an_error_that_a_run_has_not_is_a_dash():
    assert error_cells([12.34, float("nan"), 0.5, 1.0]) == ["12.3", "-", "0.500", "1.000"]


def test_a_bar_ends_no_cell_of_a_markdown_table():
    assert markdown([["a", "b"], ["1|2", "x"]]) == "| a | b |\n| --- | --- |\n| 1/2 | x |"


def test_numbers_and_what_stands_for_them_go_to_the_right():
    assert [is_number(text) for text in ("1", "-0.5", "-", "x", "1 (0 to 2)")] == [
        True,
        True,
        True,
        False,
        False,
    ]
