"""The verb `view`: what it opens, and pictures without a display."""

import cv2
import pytest

from deformpush.cli import view
from deformpush.errors import UserError
from deformpush.viewer.headless import NEEDS, has_driver
from tests.record.synthetic import SyntheticRun
from tests.viewer.recording import record


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of three pushes with its recording."""
    folder = tmp_path_factory.mktemp("view") / "run"
    record(folder, SyntheticRun(3))
    return folder


def test_without_a_display_it_says_what_to_do(run, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(UserError, match=r"^view: no display here; --screenshot PNG"):
        view.main([str(run)])


def test_all_recordings_go_to_one_viewer(run, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":7")
    started = []

    def start(command):
        started.append(command)
        return type("Done", (), {"returncode": 0})

    monkeypatch.setattr("subprocess.run", start)
    assert view.main([str(run), str(run / "recording.rrd")]) == 0
    assert started[0][1:] == [str(run / "recording.rrd")] * 2


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["nowhere"], r"^nowhere: no such run folder or recording$"),
        (["."], r"^\.: holds no recording\.rrd; record=off writes none"),
        (["RUN", "--push", "2"], "^--push: only with --screenshot"),
        (["RUN", "RUN", "--screenshot", "a.png"], "^--screenshot: of one RUN"),
        (["RUN", "--screenshot", "a.gif"], r"^--screenshot a\.gif: must end in \.png"),
        (["RUN", "--screenshot", "a.png", "--push", "4"], r"^--push 4: .* push 0 to 3$"),
        (["RUN", "--screenshot", "mine.png"], r"mine\.png exists already"),
    ],
)
def test_what_cannot_be_shown_is_said_in_one_line(run, tmp_path, monkeypatch, argv, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.png").touch()
    with pytest.raises(UserError, match=message):
        view.main([str(run) if word == "RUN" else word for word in argv])


@pytest.mark.screen
@pytest.mark.skipif(not has_driver(), reason=f"the viewer {NEEDS}")
def test_a_picture_of_a_push_needs_no_display(run, tmp_path):
    assert view.main([str(run), "--screenshot", str(tmp_path / "a.png"), "--push", "2"]) == 0
    picture = cv2.imread(str(tmp_path / "a.png"))
    assert picture.shape == (900, 1600, 3)
    assert picture.std() > 20


def test_a_run_in_parts_is_opened_whole(tmp_path):
    for name in ("recording.rrd", "recording-2.rrd", "compare.rrd"):
        (tmp_path / name).touch()
    assert view.recording(tmp_path) == [tmp_path / "recording.rrd", tmp_path / "recording-2.rrd"]
