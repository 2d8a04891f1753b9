"""Every line, band, dot, stop and word of compare.png."""

import cv2
import numpy as np
import pytest

from deformpush.record import palette
from deformpush.study import compare_figure
from deformpush.study.find_runs import find_runs
from deformpush.study.variants import BAND_CAPTION, MOST, differing, variants
from deformpush.task import TERMS
from tests.study import drawn
from tests.study.folders import finished, numbers

LABELS = [*(term.label for term in TERMS), "runs at the goal (%)"]


def groups(folder):
    runs = find_runs([folder]).runs
    return variants(runs, differing(runs))


@pytest.fixture(scope="module")
def two(sweep):
    """Two variants with two runs each."""
    return groups(sweep)


@pytest.fixture(scope="module")
def figure(two):
    return compare_figure.figure(two)


def curve(run, term) -> np.ndarray:
    """The error of a run as pushes.csv has it, in the unit of people."""
    return np.abs(numbers(run.folder.path, term.column)) * term.scale


def test_there_is_a_panel_for_each_error_and_one_for_arrivals(figure):
    assert [axis.get_ylabel() for axis in figure.axes] == LABELS
    assert {axis.get_xlabel() for axis in figure.axes} == {"push k"}


@pytest.mark.parametrize("i", range(len(TERMS)))
def test_a_variant_has_its_median_and_its_middle_half(figure, two, i):
    axis, term = figure.axes[i], TERMS[i]
    thick = [line for line in drawn.curves(axis) if line.get_linewidth() > 1]
    shown = drawn.bands(axis)
    assert [drawn.rgb(line.get_color()) for line in thick] == list(palette.RUNS[:2])
    assert [colour for colour, _, _ in shown] == list(palette.RUNS[:2])
    for line, (_, low, high), variant in zip(thick, shown, two, strict=True):
        one, other = sorted((curve(run, term) for run in variant.runs), key=len)
        one = np.r_[one, [one[-1]] * (len(other) - len(one))]
        np.testing.assert_allclose(drawn.data(line)[:, 1], (one + other) / 2)
        np.testing.assert_allclose(low, np.minimum(one, other) + abs(one - other) / 4)
        np.testing.assert_allclose(high, np.maximum(one, other) - abs(one - other) / 4)


@pytest.mark.parametrize("i", range(len(TERMS)))
def test_few_runs_are_drawn_one_by_one_with_their_ends(figure, two, i):
    axis, term = figure.axes[i], TERMS[i]
    thin = [drawn.data(line)[:, 1] for line in drawn.curves(axis) if line.get_linewidth() < 1]
    ends = [dot.get_xydata()[0] for dot in drawn.dots(axis)]
    filled = [drawn.rgb(dot.get_markerfacecolor()) != (255, 255, 255) for dot in drawn.dots(axis)]
    runs = [run for variant in two for run in variant.runs]
    for line, end, run in zip(thin, ends, runs, strict=True):
        np.testing.assert_allclose(line, curve(run, term))
        np.testing.assert_allclose(end, [len(line) - 1, line[-1]])
    assert filled == [True, False, True, True]


def test_the_stops_are_drawn_and_told(figure):
    for axis, stop in zip(figure.axes, (20.0, 7.0, 0.15), strict=False):
        assert drawn.levels(axis) == [(pytest.approx(stop), palette.STOP)]
        assert drawn.words(axis) == [f"stop {stop:.3g}"]
    assert drawn.levels(figure.axes[-1]) == []


def test_the_arrivals_rise_when_a_run_arrives(figure):
    lines = figure.axes[-1].lines
    assert [drawn.rgb(line.get_color()) for line in lines] == list(palette.RUNS[:2])
    shares = [[0] * 12 + [50] * 4, [0] * 4 + [50] * 7 + [100] * 5]
    for line, share in zip(lines, shares, strict=True):
        np.testing.assert_array_equal(drawn.data(line), np.column_stack([range(16), share]))
        assert line.get_drawstyle() == "steps-post"


def test_legend_and_caption_say_what_is_shown(figure):
    assert drawn.legend(figure) == {
        "acq.w 1: 1 of 2 runs reached the goal": palette.RUNS[0],
        "acq.w 2: 2 of 2 runs reached the goal": palette.RUNS[1],
    }
    assert figure.get_supxlabel() == f"{BAND_CAPTION}; {compare_figure.END_CAPTION}"


def test_of_many_variants_the_best_are_drawn_without_single_runs(tmp_path):
    for w in range(MOST + 1):
        for seed in (0, 1):
            status = "budget" if w == 2 else "reached"
            finished(tmp_path / f"w={w},seed={seed}", 2 + seed, seed=seed, w=float(w), status=status)
    figure = compare_figure.figure(groups(tmp_path))
    assert [text.partition(":")[0] for text in drawn.legend(figure)] == [
        f"acq.w {w}" for w in (0, 1, 3, 4, 5, 6)
    ]
    assert figure.get_supxlabel() == f"the best {MOST} of {MOST + 1} variants; {BAND_CAPTION}"
    for axis in figure.axes[:-1]:
        assert len(drawn.curves(axis)) == len(drawn.bands(axis)) == MOST
        assert drawn.dots(axis) == []


def test_one_run_has_no_band(sweep):
    figure = compare_figure.figure(groups(sweep / "acq.w=1,seed=1"))
    assert list(drawn.legend(figure)) == ["rect, error model, lcb: 0 of 1 run reached the goal"]
    for axis in figure.axes[:-1]:
        assert len(drawn.curves(axis)) == len(drawn.dots(axis)) == 1
        assert drawn.bands(axis) == []


def test_stops_that_differ_are_all_drawn(tmp_path):
    for seed, position_m in enumerate((0.02, 0.01)):
        finished(tmp_path / f"{seed}", 1, seed=seed, position_m=position_m)
    axis = compare_figure.figure(groups(tmp_path)).axes[0]
    assert [height for height, _ in drawn.levels(axis)] == pytest.approx([10, 20])
    assert drawn.words(axis) == ["stop 10", "stop 20"]


def test_the_file_shows_the_figure(two):
    """Where an axis stands, or the legend, something is drawn."""
    picture = cv2.imdecode(np.frombuffer(compare_figure.draw(two), np.uint8), cv2.IMREAD_COLOR)
    height, width, _ = picture.shape
    figure = compare_figure.figure(two)
    figure.canvas.draw()
    boxes = [axis.get_position() for axis in figure.axes]
    boxes += [figure.legends[0].get_window_extent().transformed(figure.transFigure.inverted())]
    for box in boxes:
        left, low, right, high = np.clip(box.extents, 0, 1) * [width, height, width, height]
        assert picture[round(height - high) : round(height - low), round(left) : round(right)].std() > 5
