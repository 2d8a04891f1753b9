"""What every picture of a film shows; that a player can read it is tested with the verb `video`."""

from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.text import Text

from deformpush.record import palette
from deformpush.record.finished import read
from deformpush.record.folder import RunFolder
from deformpush.study import film, run_data
from deformpush.task import TERMS
from tests.study import drawn
from tests.study.folders import columns, numbers

LAST = 4


@pytest.fixture(scope="module")
def folder(sweep):
    """A run of four pushes that reached the goal."""
    return RunFolder(sweep / "acq.w=2,seed=0")


@pytest.fixture(scope="module")
def made(folder):
    """Its film, before anything is shown."""
    return film.Frame(read(folder, "run"), run_data.read(folder))


@pytest.mark.parametrize("k", range(LAST + 1))
def test_the_title_tells_which_push_it_is_and_which_comes_next(made, folder, k):
    made.show(k)
    first, second = made.view.get_title(loc="left").split("\n")
    assert first == "rect, error model, lcb, seed 0"
    told = columns(folder.path)
    if k == LAST:
        assert second == "after push 4: reached"
    else:
        kappa, d = float(told["kappa"][k + 1]), 1e3 * float(told["d"][k + 1])
        assert second == f"after push {k}; next, initial: kappa {kappa:.2f}, d {d:.0f} mm"


@pytest.mark.parametrize("k", range(LAST + 1))
def test_the_bottom_view_is_that_of_the_push(made, k):
    made.show(k)
    view, data = made.view, made._run
    assert len(view.images) == 1
    np.testing.assert_array_equal(np.asarray(view.images[0].get_array())[..., :3], data.pictures[k])
    outlines = dict(drawn.outlines(view))
    np.testing.assert_array_equal(outlines[palette.CONTOUR], data.poses.contours[k])
    np.testing.assert_array_equal(outlines[palette.GOAL], data.poses.goal_outline)
    trail = [line for line in view.lines if drawn.rgb(line.get_color()) == palette.TRAIL]
    np.testing.assert_array_equal(drawn.data(trail[0]), data.poses.centroids[: k + 1])
    assert len(drawn.arrows(view)) == (k < LAST)


@pytest.mark.parametrize("k", range(LAST + 1))
def test_the_errors_grow_with_the_film(made, folder, k):
    made.show(k)
    assert [axis.get_ylabel() for axis in made.panels] == [term.label for term in TERMS]
    for axis, term in zip(made.panels, TERMS, strict=True):
        curve, dot = (line for line in axis.lines if not drawn.is_level(line))
        values = np.abs(numbers(folder.path, term.column)[: k + 1]) * term.scale
        np.testing.assert_allclose(drawn.data(curve), np.column_stack([range(k + 1), values]))
        np.testing.assert_allclose(drawn.data(dot), [[k, values[-1]]])
        assert {drawn.rgb(line.get_color()) for line in (curve, dot)} == {term.colour}


def test_the_panels_have_room_for_the_whole_run(made, folder):
    for axis, term, stop in zip(made.panels, TERMS, (20.0, 7.0, 0.15), strict=True):
        assert drawn.levels(axis) == [(pytest.approx(stop), palette.STOP)]
        assert drawn.words(axis) == [f"stop {stop:.3g}"]
        assert drawn.spans(axis) == [(0, LAST)], "all four pushes are initial"
        assert axis.get_xlim() == (0, LAST)
        highest = max(stop, term.scale * np.abs(numbers(folder.path, term.column)).max())
        assert axis.get_ylim() == (0, pytest.approx(1.1 * highest))
    assert made.panels[-1].get_xlabel() == "push k"


def test_in_a_long_film_the_way_is_that_of_late(made, monkeypatch):
    """All of it would cover the picture."""
    monkeypatch.setattr(film, "RECENT", 2)
    made.show(LAST)
    (trail,) = [line for line in made.view.lines if drawn.rgb(line.get_color()) == palette.TRAIL]
    np.testing.assert_array_equal(drawn.data(trail), made._run.poses.centroids[LAST - 2 :])


def test_what_stands_still_is_drawn_once(folder, monkeypatch):
    """Axes, their texts and the search for their places would take three quarters of the time."""
    drawn_whole, whole = [], Figure.draw

    def counted(figure: Figure, renderer: RendererBase) -> None:
        drawn_whole.append(figure)
        whole(figure, renderer)

    monkeypatch.setattr(Figure, "draw", counted)
    assert len(list(film.pictures(read(folder, "run"), run_data.read(folder)))) == LAST + 1
    assert len(drawn_whole) == 1


def test_a_picture_does_not_depend_on_those_before_it(folder):
    finished, data = read(folder, "run"), run_data.read(folder)
    *_, last = film.pictures(finished, data)
    with matplotlib.rc_context(film.STYLE | film.LARGER):
        frame = film.Frame(finished, data)
        frame.show(LAST)
        np.testing.assert_array_equal(frame.picture(), last)


def test_a_picture_is_drawn_of_all_of_it(folder):
    """Title, view and panels each leave something in the part of the picture where they stand."""
    finished, data = read(folder, "run"), run_data.read(folder)
    shown = list(film.pictures(finished, data))
    assert {picture.shape for picture in shown} == {(film.HEIGHT, film.WIDTH, 3)}
    assert len(shown) == LAST + 1
    steps = [np.abs(one.astype(int) - other).max() for one, other in pairwise(shown)]
    assert min(steps) > 100
    frame = film.Frame(finished, data)
    frame.show(LAST)
    with matplotlib.rc_context(film.STYLE | film.LARGER):
        frame.picture()
        title = next(text for text in frame.view.findobj(Text) if text.get_text().endswith("reached"))
        parts = [part.get_window_extent() for part in (title, frame.view, *frame.panels)]
    for part in parts:
        left, right = round(part.x0), round(part.x1)
        top, bottom = round(film.HEIGHT - part.y1), round(film.HEIGHT - part.y0)
        assert shown[LAST][top:bottom, left:right].std() > 5
