"""Pictures are decoded one by one, and never larger than a camera makes them."""

import tracemalloc

import cv2
import numpy as np
import pytest

from deformpush.cell.picture_file import MOST_PX
from deformpush.errors import UserError
from deformpush.record.pictures import Views, decode, encode


def test_a_picture_is_made_smaller_and_never_larger(run):
    image = run[1][0].view.picture
    assert decode(encode(image, 100, 85)).shape == (100, 100, 3)
    whole = decode(encode(image, 9999, 95))
    assert whole.shape == image.shape
    assert np.abs(whole.astype(int) - image).mean() < 2


def claiming(picture: bytes, height: int, width: int) -> bytes:
    """A JPEG that says another size of itself."""
    at = picture.index(b"\xff\xc0")
    return picture[: at + 5] + height.to_bytes(2, "big") + width.to_bytes(2, "big") + picture[at + 9 :]


@pytest.mark.parametrize(
    "harm",
    [
        lambda whole: b"",
        lambda whole: b"\xff\xd8",
        lambda whole: b"no picture",
        lambda whole: b"\xff\xd8" + b"\xff\xe0\x00\x00" * 1000,
        lambda whole: whole[:200],
        lambda whole: claiming(whole, 65535, 65535),
        lambda whole: claiming(whole, MOST_PX + 1, 10),
        lambda whole: claiming(whole, 0, 0),
        lambda whole: cv2.imencode(".png", np.zeros((9, 9, 3), np.uint8))[1].tobytes(),
    ],
)
def test_what_is_no_picture_of_a_camera_is_refused(harm, run):
    whole = encode(run[1][0].view.picture, 100, 85)
    views = Views([whole, harm(whole)], "views.npz")
    assert views[0].shape == (100, 100, 3)
    tracemalloc.start()
    with pytest.raises(UserError, match=r"^views\.npz: picture 1 is damaged \(") as caught:
        views[1]
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()
    assert "\n" not in str(caught.value)


def test_thousands_of_pictures_are_decoded_when_they_are_asked_for(run):
    picture = encode(run[1][0].view.picture, 100, 85)
    tracemalloc.start()
    views = Views([picture] * 5000, "views.npz")
    assert len(views) == 5000
    assert views[-1].shape == views[4999].shape == (100, 100, 3)
    assert len(views[10:20]) == 10
    assert sum(1 for image in views if image.shape == (100, 100, 3)) == 5000
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()
    with pytest.raises(IndexError):
        views[5000]
