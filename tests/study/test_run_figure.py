"""The figure of a run shows what its folder holds.

The modules that read it and draw its bottom views, `run_data` and `bottom_view_plot`, are tested here too.
"""

from dataclasses import replace

import cv2
import matplotlib
import numpy as np
import pytest
from matplotlib.container import BarContainer
from matplotlib.figure import Figure

from deformpush.record import palette
from deformpush.record.poses import read_views
from deformpush.study import bottom_view_plot, run_data, run_figure
from deformpush.task import TERMS
from tests.study import drawn
from tests.study.folders import numbers, written

LAST, INITIAL = 14, 10


@pytest.fixture(scope="module")
def folder(tmp_path_factory, run):
    """A run of 14 pushes, the first ten of them initial."""
    return written(tmp_path_factory.mktemp("figure") / "run", *run)


@pytest.fixture(scope="module")
def figure(folder):
    """Its figure."""
    with matplotlib.rc_context(run_figure.STYLE):
        return run_figure.figure(run_data.read(folder))


@pytest.mark.parametrize(
    ("pushes", "moments"),
    [(0, [0, 0, 0, 0]), (3, [0, 1, 2, 3]), (10, [0, 3, 7, 10]), (14, [0, 10, 12, 14])],
)
def test_four_moments_are_shown(tmp_path, run, pushes, moments):
    info, rows = run
    folder = written(tmp_path, info, rows[: pushes + 1], "budget")
    assert run_data.read(folder).moments == moments
    titles = [axis.get_title() for axis in run_figure.figure(run_data.read(folder)).axes]
    assert titles[:4] == [f"k = {k}" for k in moments]
    run_figure.draw(folder)
    picture = cv2.imread(str(folder.figures / "run.png"))
    height, width = round(run_figure.HEIGHT * run_figure.DPI), round(run_figure.WIDTH * run_figure.DPI)
    assert picture.shape == (height, width, 3)


def test_without_an_initial_design_the_moments_are_evenly_spaced(folder):
    data = run_data.read(folder)
    assert replace(data, pushes=data.pushes.assign(phase="exploit")).moments == [0, 5, 9, 14]


def test_the_arrow_of_a_short_push_is_no_longer_than_the_push(folder):
    data = run_data.read(folder)
    start, end = data.poses.starts.copy(), data.poses.ends.copy()
    end[1] = start[1] + [0.003, 0.004]
    axis = Figure().subplots()
    bottom_view_plot.plot(axis, replace(data, poses=replace(data.poses, starts=start, ends=end)), 0)
    (arrow,) = drawn.arrows(axis)
    along = (np.asarray(arrow.get_xy()) - start[1]) @ [0.6, 0.8]
    assert along.min() == pytest.approx(0, abs=1e-12)
    assert along.max() == pytest.approx(0.005)


def test_the_file_shows_the_figure(folder, figure):
    """Every part of the page where an axis stands is drawn in it."""
    run_figure.draw(folder)
    picture = cv2.imread(str(folder.figures / "run.png"))
    height, width, _ = picture.shape
    for axis in figure.axes:
        left, low, right, high = axis.get_position().extents * [width, height, width, height]
        assert picture[round(height - high) : round(height - low), round(left) : round(right)].std() > 5


def test_it_has_four_views_and_two_panels(figure):
    assert [len(axis.images) for axis in figure.axes[:4]] == [1, 1, 1, 1]
    assert figure.axes[4].get_ylabel() == "error (-)"
    assert len(figure.axes) == 4 + 1 + 3, "the actions have an axis each for kappa, d and xi"


@pytest.mark.parametrize(("i", "k"), [(0, 0), (1, 10), (2, 12), (3, 14)])
def test_a_view_shows_picture_goal_contour_and_next_push(figure, folder, run, i, k):
    axis, (info, rows) = figure.axes[i], run
    picture = np.asarray(axis.images[0].get_array())
    np.testing.assert_array_equal(picture[..., :3], read_views(folder.views)[k])
    ((ground, filled),) = [part for part in drawn.fills(axis) if part[0] != palette.NEXT_PUSH]
    assert ground == palette.lighter(palette.GOAL, 0.6)
    np.testing.assert_array_equal(filled, info.target.outline)
    shown = dict(drawn.outlines(axis))
    assert list(shown) == [palette.GOAL, palette.CONTOUR]
    np.testing.assert_array_equal(shown[palette.GOAL], info.target.outline)
    np.testing.assert_array_equal(shown[palette.CONTOUR], rows[k].view.seen.contour)
    pushes = [] if k == LAST else [rows[k + 1].action.path]
    assert [dot.get_xydata()[0].tolist() for dot in drawn.dots(axis)] == [p.start.tolist() for p in pushes]
    arrows = drawn.arrows(axis)
    assert len(arrows) == len(pushes)
    for arrow, path in zip(arrows, pushes, strict=True):
        assert drawn.rgb(arrow.get_facecolor()) == palette.NEXT_PUSH
        corners = np.asarray(arrow.get_xy())
        assert np.linalg.norm(corners - path.end, axis=1).min() < 1e-9
        tail = corners[np.argsort(np.linalg.norm(corners - path.start, axis=1))[:2]]
        np.testing.assert_allclose(np.unique(tail, axis=0).mean(0), path.start, atol=3e-3)


def test_the_views_show_the_same_square_with_a_scale(figure, run):
    info, rows = run
    limits = {(axis.get_xlim(), axis.get_ylim()) for axis in figure.axes[:4]}
    (((left, right), (low, high)),) = limits
    assert right - left == pytest.approx(high - low)
    everything = np.concatenate([info.target.outline, *(rows[k].view.seen.contour for k in (0, 10, 12, 14))])
    assert ((everything > (left, low)) & (everything < (right, high))).all()
    (bar,) = drawn.curves(figure.axes[0])
    assert np.ptp(bar.get_xdata()) == pytest.approx(0.1)
    assert drawn.words(figure.axes[0]) == ["100 mm"]


def test_picture_and_contour_lie_on_each_other(figure, run):
    """The contour is drawn in metres over the picture: they agree to a pixel."""
    image = figure.axes[1].images[0]
    left, right, low, high = image.get_extent()
    rgba = np.asarray(image.get_array())
    rows, columns = np.nonzero(rgba[..., 3] > 128)
    x = left + (columns + 0.5) / rgba.shape[1] * (right - left)
    y = high - (rows + 0.5) / rgba.shape[0] * (high - low)
    middle = [(x.min() + x.max()) / 2, (y.min() + y.max()) / 2]
    contour = run[1][10].view.seen.contour
    np.testing.assert_allclose(middle, (contour.min(0) + contour.max(0)) / 2, atol=0.6 / 480)


def test_the_errors_are_drawn_with_their_stops(figure, folder, run):
    (axis,) = [axis for axis in figure.axes if axis.get_ylabel() == "error (-)"]
    lines = drawn.curves(axis)
    assert [drawn.rgb(line.get_color()) for line in lines] == [term.colour for term in TERMS]
    for line, term in zip(lines, TERMS, strict=True):
        expected = np.column_stack([range(LAST + 1), np.abs(numbers(folder.path, term.symbol))])
        np.testing.assert_array_equal(drawn.data(line), expected)
    stops = zip(run[0].error_stops(), TERMS, strict=True)
    assert drawn.levels(axis) == [(pytest.approx(stop), term.colour) for stop, term in stops]
    assert drawn.legend(axis) == {
        "$e_c$, stop 20 mm": TERMS[0].colour,
        r"$|e_\theta|$, stop 7 deg": TERMS[1].colour,
        r"$e_\gamma$, stop 0.15": TERMS[2].colour,
    }
    assert drawn.spans(axis) == [(0, INITIAL)]
    assert drawn.words(axis) == ["initial"]
    assert axis.get_xlabel() == "push k"
    assert axis.get_ylim()[0] == 0


def test_the_actions_are_drawn_with_what_came_of_them(figure, folder):
    kappa, xi, d = figure.axes[5:]
    labels = [r"contour ratio $\kappa$ (-)", r"change of error $\xi$ (-)", "distance $d$ (mm)"]
    assert [axis.get_ylabel() for axis in (kappa, xi, d)] == labels
    k = range(1, LAST + 1)
    for axis, column, scale, colour in ((kappa, "kappa", 1.0, palette.KAPPA), (d, "d", 1e3, palette.D)):
        (line,) = drawn.curves(axis)
        assert drawn.rgb(line.get_color()) == colour
        expected = np.column_stack([k, scale * np.array(numbers(folder.path, column)[1:])])
        np.testing.assert_allclose(drawn.data(line), expected)
    (bars,) = [container for container in xi.containers if isinstance(container, BarContainer)]
    assert {drawn.rgb(bar.get_facecolor()) for bar in bars} == {palette.XI}
    assert [bar.get_x() + bar.get_width() / 2 for bar in bars] == pytest.approx(k)
    assert [bar.get_height() for bar in bars] == numbers(folder.path, "xi")[1:]
    assert drawn.levels(xi) == [(0.0, palette.XI)]
    assert drawn.spans(xi) == [(0, INITIAL)]
    assert kappa.get_ylim() == pytest.approx((-0.04, 1.04))
    assert d.get_ylim() == pytest.approx((9.2, 30.8))


def test_a_killed_run_is_drawn_up_to_where_all_files_agree(tmp_path, run):
    info, rows = run
    folder = written(tmp_path, info, rows[:13])
    lines = folder.table.read_text().splitlines(keepends=True)
    folder.table.write_text("".join(lines[:-2]))
    assert run_data.read(folder).last == 10
