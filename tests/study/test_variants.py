"""What tells runs apart, and which belong together."""

import numpy as np
import pytest

from deformpush.record.finished import ERRORS
from deformpush.study.bands import band, held
from deformpush.study.compare_figure import arrived
from deformpush.study.find_runs import gather
from deformpush.study.tables import run_rows, table_csv, terminal
from deformpush.study.variants import differing, show, titles, variants
from tests.study.folders import finished


def test_what_follows_from_an_option_is_no_difference_of_its_own(tmp_path):
    """Not its own settings, not what repeats them elsewhere, and not what is recorded."""
    finished(tmp_path / "a", 1, name="rect")
    finished(tmp_path / "b", 1, name="meat", seed=1)
    assert differing(gather([tmp_path]).runs) == {"object": ["rect", "meat"], "seed": [0, 1]}


def test_a_setting_changed_within_its_option_is_a_difference(tmp_path):
    finished(tmp_path / "a", 1, w=1.0)
    finished(tmp_path / "b", 1, w=2.0)
    finished(tmp_path / "c", 1, w=2.0, name="meat")
    assert differing(gather([tmp_path]).runs) == {
        "object": ["rect", "rect", "meat"],
        "acq.w": [1.0, 2.0, 2.0],
    }


def test_runs_that_differ_in_their_seed_are_one_variant(sweep):
    runs = gather([sweep]).runs
    difference = differing(runs)
    groups = variants(runs, difference)
    assert [(one.label, len(one.runs), one.reached) for one in groups] == [
        ("acq.w 1", 2, 1),
        ("acq.w 2", 2, 2),
    ]
    assert titles(runs, difference) == [f"acq.w {w}, seed {seed}" for w in (1, 2) for seed in (0, 1)]


def test_a_single_run_is_a_variant(sweep):
    runs = gather([sweep / "acq.w=1,seed=0"]).runs
    assert differing(runs) == {}
    assert [one.label for one in variants(runs, {})] == ["rect, gp model, lcb"]
    assert titles(runs, {}) == ["acq.w=1,seed=0"]


def test_a_run_that_has_ended_keeps_its_last_error():
    np.testing.assert_array_equal(
        held([np.array([3.0, 1.0]), np.array([4.0, 2.0, 5.0])]), [[3, 1, 1], [4, 2, 5]]
    )


def test_bands_are_quartiles_over_all_runs(sweep):
    runs = gather([sweep]).runs
    one = variants(runs, differing(runs))[0]
    spread = band(one, ERRORS[0])
    assert len(spread.middle) == 16
    curves = [run.error(ERRORS[0]) for run in one.runs]
    assert spread.middle[-1] == pytest.approx((curves[0][-1] + curves[1][-1]) / 2)
    assert (spread.low <= spread.middle).all()
    assert (spread.middle <= spread.high).all()
    np.testing.assert_array_equal(arrived(one, 15), [0.0] * 12 + [0.5] * 4)


def test_the_table_gives_people_their_units(sweep):
    runs = gather([sweep]).runs
    header, first, *_ = run_rows(runs, differing(runs))
    row = dict(zip(header, first, strict=True))
    assert row["acq.w"] == "1"
    assert row["position (mm)"] == f"{1e3 * runs[0].summary.position_error_m:.1f}"
    assert row["run"] == "acq.w=1,seed=0"
    widths = {line.index("acq.w=") for line in terminal(run_rows(runs, {})).splitlines()[1:]}
    assert len(widths) == 1


def test_the_file_has_every_number_of_the_summaries(sweep):
    import csv

    runs = gather([sweep]).runs
    rows = list(csv.DictReader(table_csv(runs, differing(runs)).splitlines()))
    assert [row["run"] for row in rows] == [run.name for run in runs]
    assert [float(row["e_T"]) for row in rows] == [run.summary.e_T for run in runs]
    assert [row["acq.w"] for row in rows] == ["1", "1", "2", "2"]


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (0.5, "0.5"), (2.0, "2"), ([0.1, -0.15], "[0.1,-0.15]"), (True, "True"), ("x", "x")],
)
def test_settings_are_shown_as_people_write_them(value, text):
    assert show(value) == text
