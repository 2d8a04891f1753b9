"""The verb `video`: a film of the right pictures that a player can read."""

import shutil

import av
import numpy as np
import pytest

from deformpush.cli import video
from deformpush.errors import UserError
from deformpush.record.finished import read
from deformpush.record.folder import RunFolder
from deformpush.study import film, run_data


def test_a_film_shows_every_push_and_then_the_end(sweep, tmp_path):
    path, run = tmp_path / "a.mp4", RunFolder(sweep / "acq.w=2,seed=0")
    assert video.main([str(run.path), "--out", str(path), "--seconds", "0.3"]) == 0
    with av.open(str(path)) as file:
        stream = file.streams.video[0]
        assert (stream.codec_context.name, stream.width, stream.height) == ("h264", 1280, 720)
        frames = [frame.to_ndarray(format="rgb24") for frame in file.decode(stream)]
    assert len(frames) == 4 * 3 + 20
    states = [
        picture[::3, ::3].astype(int) for picture in film.pictures(read(run, "run"), run_data.read(run))
    ]
    for i, frame in enumerate(frames):
        apart = [np.abs(frame[::3, ::3] - state).mean() for state in states]
        assert np.argmin(apart) == min(i // 3, 4)
        assert min(apart) < 2, "but for the compression it is the picture of that state"


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--out", "a.gif"], r"^--out a\.gif: must end in \.mp4$"),
        (["--seconds", "0"], r"^--seconds 0: must be 0\.1 to 10$"),
    ],
)
def test_what_makes_no_film_is_refused(sweep, flags, message):
    with pytest.raises(UserError, match=message):
        video.main([str(sweep / "acq.w=2,seed=0"), *flags])


def test_a_run_that_did_not_finish_is_refused(sweep, tmp_path):
    run = shutil.copytree(sweep / "acq.w=2,seed=0", tmp_path / "run")
    (run / "summary.json").unlink()
    with pytest.raises(UserError, match=r"no summary\.json: it still runs, or was killed$"):
        video.main([str(run)])
    assert not (run / "video.mp4").exists()
