"""What lies in ranges of colour."""

import numpy as np
import pytest

from deformpush.cell.segmentation import HsvRanges

BLUE = ((100, 130, 40), (130, 255, 255))
RED = ((170, 100, 50), (10, 255, 255))
PICTURE = np.array([[(26, 64, 230), (230, 30, 20), (230, 20, 40), (20, 200, 30), (255, 255, 255)]], np.uint8)


@pytest.mark.parametrize(
    ("ranges", "found"),
    [
        ((BLUE,), [True, False, False, False, False]),
        ((RED,), [False, True, True, False, False]),
        ((BLUE, RED), [True, True, True, False, False]),
        ((((0, 0, 200), (179, 30, 255)),), [False, False, False, False, True]),
    ],
)
def test_one_range_or_several_and_red_on_both_sides_of_hue_0(ranges, found):
    assert HsvRanges(ranges).mask(PICTURE).tolist() == [found]


@pytest.mark.parametrize("high", [(130, 90, 255), (130, 255, 30)])
def test_a_range_out_of_order_is_refused(high):
    with pytest.raises(
        ValueError, match=r"^ranges: saturation and value of \[100, 130, 40\] must not exceed "
    ):
        HsvRanges(((BLUE[0], high),))
