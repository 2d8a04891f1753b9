"""A legend stands where least is drawn."""

import numpy as np
import pytest
import rerun.blueprint as rrb

from deformpush.viewer.legends import Legends

K = range(20)


@pytest.mark.parametrize(
    ("curve", "corner"),
    [
        (lambda k: -k, rrb.Corner2D.RightTop),
        (lambda k: k, rrb.Corner2D.LeftTop),
        (lambda k: abs(k - 9.5) ** 0.5, rrb.Corner2D.LeftBottom),
        (lambda k: 1.0 if k < 12 else float(k % 2), rrb.Corner2D.LeftBottom),
        (lambda k: 5.0, rrb.Corner2D.LeftTop),
    ],
)
def test_the_corner_with_least_in_it_is_taken(curve, corner):
    legends = Legends()
    for k in K:
        legends.add("strip", k, [curve(k), np.nan])
    assert legends.free() == {"strip": corner}


def test_a_strip_without_numbers_has_no_corner():
    legends = Legends()
    legends.add("strip", 0, [np.nan])
    assert legends.free() == {}
