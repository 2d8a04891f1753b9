"""What compare.rrd is made of; what is in the file itself is tested with the verb `compare`."""

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.record.poses import read_pictures
from deformpush.study import compare_recording
from deformpush.study.find_runs import find_runs
from deformpush.study.variants import differing, titles, variants
from deformpush.task import TERMS, TOTAL
from tests.study.folders import finished, numbers

QUANTITIES = {quantity.name: quantity for quantity in (*TERMS, TOTAL)}


class Study:
    """Runs below a folder, with all that is derived from them."""

    def __init__(self, folder):
        self.runs = find_runs([folder]).runs
        self.differences = differing(self.runs)
        self.variants = variants(self.runs, self.differences)
        self.names = titles(self.runs, self.differences)

    def lines(self):
        return compare_recording.lines(self.variants, self.names)

    def views(self):
        return compare_recording.views(self.variants, self.names)

    def about(self):
        return compare_recording.about(self.runs, self.differences, self.variants)


@pytest.fixture(scope="module")
def few(sweep):
    """Two variants with two runs each."""
    return Study(sweep)


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """Two variants with seven runs each."""
    folder = tmp_path_factory.mktemp("many")
    for seed in range(7):
        for w in (1.0, 2.0):
            finished(folder / f"w={w:g},seed={seed}", 2 + seed, seed=seed, w=w)
    return Study(folder)


def error(run, name) -> np.ndarray:
    quantity = QUANTITIES[name]
    return np.abs(numbers(run.folder.path, quantity.column)) * quantity.scale


def test_few_runs_have_a_line_each_in_the_colour_of_their_variant(few):
    lines = few.lines()
    assert [(line.title, line.colour) for line in lines] == [
        (f"acq.w {w}", palette.RUNS[w - 1]) for w in (1, 1, 2, 2)
    ]
    for line, run in zip(lines, few.runs, strict=True):
        assert list(line.errors) == list(QUANTITIES)
        assert line.band is None
        for name, values in line.errors.items():
            np.testing.assert_allclose(values, error(run, name))


def test_the_runs_of_one_variant_have_colours_of_their_own(sweep, tmp_path):
    for seed in range(2):
        finished(tmp_path / f"seed={seed}", 2, seed=seed)
    lines = Study(tmp_path).lines()
    assert [(line.title, line.colour) for line in lines] == [(f"seed {i}", palette.RUNS[i]) for i in (0, 1)]


def test_many_runs_become_a_line_and_a_band_a_variant(many):
    lines = many.lines()
    assert [(line.title, line.colour) for line in lines] == [
        ("acq.w 1 (7)", palette.RUNS[0]),
        ("acq.w 2 (7)", palette.RUNS[1]),
    ]
    for line, variant in zip(lines, many.variants, strict=True):
        for name in QUANTITIES:
            curves = [error(run, name) for run in variant.runs]
            curves = np.stack([np.r_[one, [one[-1]] * (9 - len(one))] for one in curves])
            low, high = line.band[name]
            np.testing.assert_allclose(line.errors[name], np.median(curves, axis=0))
            np.testing.assert_allclose(low, np.quantile(curves, 0.25, axis=0))
            np.testing.assert_allclose(high, np.quantile(curves, 0.75, axis=0))


def test_runs_stand_side_by_side_in_turn(few, many):
    views = few.views()
    assert [(view.title, view.ended) for view in views] == [
        ("acq.w 1, seed 0", "reached after 12 pushes"),
        ("acq.w 2, seed 0", "reached after 4 pushes"),
        ("acq.w 1, seed 1", "budget after 15 pushes"),
        ("acq.w 2, seed 1", "reached after 11 pushes"),
    ]
    assert views[0].pictures == read_pictures(few.runs[0].folder.views)
    assert len(views[2].poses.contours) == 16
    assert len(many.views()) == compare_recording.SIDE_BY_SIDE


def test_a_run_without_pictures_does_not_stand_there(tmp_path):
    for seed in range(2):
        finished(tmp_path / f"seed={seed}", 2, seed=seed)
    (tmp_path / "seed=0" / "views.npz").unlink()
    assert [view.title for view in Study(tmp_path).views()] == ["seed 1"]


def test_the_text_tells_what_differs(few, many):
    text = few.about()
    assert text.startswith("**4 runs, 2 variants**; they differ in `acq.w`, `seed`.")
    assert text.count("\n| acq.w ") == 2
    assert text.count("\n| rect ") == 4, "the runs while they are few"
    assert many.about().count("\n| rect ") == 0
    assert "In the panels of the errors: line: median over seeds" in many.about()
