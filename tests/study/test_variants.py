"""What tells runs apart, and which belong together."""

import numpy as np
import pytest

from deformpush.study.find_runs import find_runs
from deformpush.study.variants import (
    MOST,
    best,
    differing,
    in_turn,
    lengthened,
    show,
    stop_values,
    titles,
    variants,
)
from deformpush.task import TERMS, TOTAL
from tests.study.folders import finished, numbers


def test_what_follows_from_an_option_is_no_difference_of_its_own(tmp_path):
    """Not its own settings, not what repeats them elsewhere, and not what is recorded."""
    finished(tmp_path / "a", 1, name="rect")
    finished(tmp_path / "b", 1, name="meat", seed=1)
    assert differing(find_runs([tmp_path]).runs) == {"object": ["rect", "meat"], "seed": [0, 1]}


def test_a_setting_changed_within_its_option_is_a_difference(tmp_path):
    finished(tmp_path / "a", 1, w=1.0)
    finished(tmp_path / "b", 1, w=2.0)
    finished(tmp_path / "c", 1, w=2.0, name="meat")
    assert differing(find_runs([tmp_path]).runs) == {
        "object": ["rect", "rect", "meat"],
        "acq.w": [1.0, 2.0, 2.0],
    }


def test_runs_that_differ_in_their_seed_are_one_variant(sweep):
    runs = find_runs([sweep]).runs
    difference = differing(runs)
    groups = variants(runs, difference)
    assert [(one.label, len(one.runs), one.reached) for one in groups] == [
        ("acq.w 1", 2, 1),
        ("acq.w 2", 2, 2),
    ]
    assert titles(runs, difference) == {
        f"acq.w={w},seed={seed}": f"acq.w {w}, seed {seed}" for w in (1, 2) for seed in (0, 1)
    }


def test_a_single_run_is_a_variant(sweep):
    runs = find_runs([sweep / "acq.w=1,seed=0"]).runs
    assert differing(runs) == {}
    assert [one.label for one in variants(runs, {})] == ["rect, error model, lcb"]
    assert titles(runs, {}) == {"acq.w=1,seed=0": "acq.w=1,seed=0"}


def test_a_run_that_has_ended_keeps_its_last_error():
    np.testing.assert_array_equal(
        lengthened([np.array([3.0, 1.0]), np.array([4.0, 2.0, 5.0])]), [[3, 1, 1], [4, 2, 5]]
    )


@pytest.mark.parametrize("quantity", [*TERMS, TOTAL])
def test_bands_are_quartiles_over_all_runs(sweep, quantity):
    runs = find_runs([sweep]).runs
    one = variants(runs, differing(runs))[0]
    band = one.band(quantity)
    short, long = (np.abs(numbers(run.folder.path, quantity.column)) * quantity.scale for run in one.runs)
    short = np.r_[short, [short[-1]] * 3]
    assert len(short) == len(long) == len(band.middle) == 16
    low, high = np.minimum(short, long), np.maximum(short, long)
    np.testing.assert_allclose(band.low, low + (high - low) / 4)
    np.testing.assert_allclose(band.middle, (low + high) / 2)
    np.testing.assert_allclose(band.high, high - (high - low) / 4)


def test_a_run_arrives_with_its_last_push(sweep):
    one, other = _groups(sweep)
    np.testing.assert_array_equal(one.arrived(15), [0.0] * 12 + [0.5] * 4)
    np.testing.assert_array_equal(other.arrived(12), [0.0] * 4 + [0.5] * 7 + [1.0] * 2)


def test_stops_that_differ_are_all_told(tmp_path):
    for seed, position_m in enumerate((0.02, 0.01, 0.02)):
        finished(tmp_path / f"{seed}", 1, seed=seed, position_m=position_m)
    runs = find_runs([tmp_path]).runs
    assert [stop_values(runs, quantity) for quantity in (*TERMS, TOTAL)] == [
        [pytest.approx(10.0), pytest.approx(20.0)],
        [pytest.approx(7.0)],
        [pytest.approx(0.15)],
        [],
    ]


def test_the_best_variants_arrive_most_often_and_then_soonest(tmp_path):
    for i in range(MOST + 2):
        arrives = "reached" if i % 2 else "budget"
        finished(tmp_path / f"w={i}", 1 + (7 * i) % 5, w=float(i), status=arrives)
    runs = find_runs([tmp_path]).runs
    labels = [one.label for one in best(variants(runs, differing(runs)))]
    # Pushes are 1, 3, 5, 2, 4, 1, 3, 5 for w = 0 ... 7, and the odd ones arrived.
    assert labels == [f"acq.w {w}" for w in (5, 3, 1, 7, 0, 6)]
    assert best(variants(runs[:2], differing(runs[:2]))) == variants(runs[:2], differing(runs[:2]))


def test_runs_come_in_turn_one_of_each_variant(sweep):
    assert [run.name for run in in_turn(_groups(sweep))] == [
        f"acq.w={w},seed={seed}" for seed in (0, 1) for w in (1, 2)
    ]


def _groups(sweep):
    runs = find_runs([sweep]).runs
    return variants(runs, differing(runs))


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (0.5, "0.5"), (2.0, "2"), ([0.1, -0.15], "[0.1,-0.15]"), (True, "True"), ("x", "x")],
)
def test_settings_are_shown_as_people_write_them(value, text):
    assert show(value) == text
