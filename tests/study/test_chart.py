"""Charts of a page: what they keep, and where they draw it."""

import re

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.study.chart import Chart, css, ticks
from tests.study import html_tree


def places(path: str) -> list[tuple[float, float]]:
    """Points that an SVG path goes through, in percent of the plot."""
    return [(float(x), float(y)) for x, y in re.findall(r"[ML]([-\d.]+) ([-\d.]+)", path)]


@pytest.fixture
def chart():
    """Values from 0 to 2 over four k, so that the plot goes from 0 to 2.1."""
    made = Chart("height <m>", 4)
    made.band(np.array([0.0, np.nan, 0.5]), np.array([1.0, 1.0, 1.5]), palette.D, "bounds")
    made.line(np.array([0.0, 2.0, np.nan, 1.0, 2.0]), palette.XI, "as it came")
    made.dots(np.array([np.nan, 1.0]), palette.KAPPA)
    made.stop(0.5, palette.STOP)
    made.initial = 2
    return made


def test_a_chart_keeps_what_it_shows(chart):
    assert [(mark.kind, mark.key, mark.colour) for mark in chart.marks] == [
        ("area", "bounds", palette.D),
        ("line", "as it came", palette.XI),
        ("dots", "", palette.KAPPA),
        ("line", "stop 0.5", palette.STOP),
    ]
    area, line, dots, stop = (
        [*zip(mark.k.tolist(), mark.values.tolist(), strict=True)] for mark in chart.marks
    )
    assert area == [(0, 0.0), (2, 0.5), (2, 1.5), (0, 1.0)]
    assert line == [(0, 0.0), (1, 2.0), (3, 1.0), (4, 2.0)]
    assert dots == [(1, 1.0)]
    assert stop == [(k, 0.5) for k in range(5)]


def test_each_mark_is_drawn_in_its_place_and_colour(chart):
    tree = html_tree.read(chart.html())
    drawn = [node.attributes for node in tree.all("path") if node.attributes.get("class") != "grid"]
    assert len(drawn) == len(chart.marks)
    for attributes, mark in zip(drawn, chart.marks, strict=True):
        expected = [(25 * k, 100 * (2.1 - v) / 2.1) for k, v in zip(mark.k, mark.values, strict=True)]
        assert places(attributes["d"]) == [pytest.approx(place, abs=0.01) for place in expected]
        assert css(mark.colour) in (attributes.get("stroke"), attributes.get("fill"))
    assert drawn[0]["d"].endswith("Z")
    assert drawn[3]["stroke-dasharray"] == "5 4"


def test_title_keys_and_scales_stand_beside_it(chart):
    tree = html_tree.read(chart.html())
    caption = tree.one("figcaption")
    assert caption.one("b").text == "height <m>"
    assert [key.text for key in caption.all("span")] == ["bounds", "as it came", "stop 0.5"]
    swatches = [key.one("i").attributes["style"] for key in caption.all("span")]
    assert swatches == [f"background:{css(colour)}" for colour in (palette.D, palette.XI, palette.STOP)]
    assert [tick.text for tick in tree.one(class_="ys").all("span")] == ["0", "1", "2"]
    assert [tick.text for tick in tree.one(class_="xs").all("span")] == ["0", "1", "2", "3", "4"]
    assert tree.one("rect", class_="initial").attributes["width"] == "50.00"


def test_steps_keep_a_value_until_the_next():
    chart = Chart("share", 2)
    chart.steps(np.array([0.0, 50.0, 100.0]), palette.XI, "all")
    (mark,) = chart.marks
    assert (mark.k.tolist(), mark.values.tolist()) == ([0, 1, 1, 2, 2], [0, 0, 50, 50, 100])


def test_a_stop_that_there_is_not_is_not_drawn():
    chart = Chart("share", 2)
    chart.stop(np.nan, palette.STOP)
    assert chart.marks == []


def test_a_chart_without_numbers_is_still_a_chart():
    assert html_tree.read(Chart("nothing", 0).html()).one("figcaption").text == "nothing"


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0, 250, [0, 100, 200]),
        (0, 1, [0, 0.5, 1]),
        (-0.7, 0.5, [-0.5, 0, 0.5]),
        (0, 0.16, [0, 0.05, 0.1, 0.15]),
    ],
)
def test_ticks_are_round(low, high, expected):
    assert ticks(low, high, 4) == pytest.approx(expected)
