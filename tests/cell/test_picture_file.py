"""Pictures from anywhere: decoded if they are plain and of a sane size, else refused with a reason."""

import os
import tracemalloc

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.cell import picture_file

PICTURE = np.random.default_rng(0).integers(0, 255, (24, 40, 3), np.uint8)
FILES = {
    "png": picture_file.png(PICTURE),
    "jpg": cv2.imencode(".jpg", PICTURE[..., ::-1])[1].tobytes(),
}


@pytest.mark.parametrize("kind", FILES)
def test_what_was_written_is_read(kind, tmp_path):
    file = tmp_path / f"a.{kind}"
    file.write_bytes(FILES[kind])
    read = picture_file.read(file)
    assert read.shape == PICTURE.shape
    assert np.abs(read.astype(int) - PICTURE).mean() < (0.1 if kind == "png" else 60)


@given(
    kind=st.sampled_from(sorted(FILES)),
    cut=st.integers(0, 4000),
    at=st.integers(0, 600),
    byte=st.binary(max_size=9),
)
def test_damaged_files_are_decoded_or_refused_and_take_no_memory(kind, cut, at, byte):
    whole = FILES[kind]
    data = whole[:at] + byte + whole[at + len(byte) :][:cut]
    tracemalloc.start()
    said = ""
    try:
        said = str(picture_file.decode(data).ndim)
    except ValueError as error:
        said = str(error)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert said
    assert "\n" not in said
    assert peak < 3 * picture_file.MOST_PX**2


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    with pytest.raises(ValueError, match=r"^no regular file$"):
        picture_file.read(tmp_path / "pipe.png")


def test_a_large_picture_is_made_smaller():
    assert picture_file.shrunk(np.zeros((100, 300, 3), np.uint8), 150).shape == (50, 150, 3)
    assert picture_file.shrunk(np.zeros((1, 900, 3), np.uint8), 90).shape == (1, 90, 3)
    assert picture_file.shrunk(PICTURE, 40) is PICTURE
