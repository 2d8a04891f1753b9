"""A headless viewer opens the recording and no view reports an error."""

from time import monotonic, sleep

import cv2
import pytest
from rerun.experimental import ViewerClient

from deformpush.viewer import live
from deformpush.viewer.headless import NEEDS, complaints, free_port, has_driver, viewer
from tests.record.synthetic import SyntheticRun, kuka
from tests.viewer.recording import record

pytestmark = [
    pytest.mark.screen,
    pytest.mark.skipif(not has_driver(), reason=f"the viewer {NEEDS}"),
]


@pytest.fixture(scope="module")
def client():
    """A viewer without a window, on a free port, that is gone afterwards."""
    with viewer() as running:
        yield running


@pytest.mark.parametrize(
    ("options", "views"),
    [
        ({}, 16),
        ({"scene": False, "motion": False, "image_px": 240}, 15),
        ({"scene": False, "motion": False, "maps": False}, 12),
    ],
    ids=["full", "light", "least"],
)
def test_no_view_reports_an_error(client, tmp_path, options, views):
    path = record(tmp_path / "run", SyntheticRun(12, urdf=kuka()), **options)
    client.open(str(path))
    for at in ({"sequence": 0}, {"sequence": 11}):
        client.set_time("push", **at, play_state="paused")
        client.save_screenshot(str(tmp_path / "view.png"))
        assert complaints(client) == []
    assert len(client.get_state().views) == views
    picture = cv2.imread(str(tmp_path / "view.png"))
    assert picture.shape == (900, 1600, 3)
    assert picture.std() > 20
    client.close("all")


def test_a_live_viewer_sees_the_run_while_it_is_saved(client, tmp_path):
    path = record(tmp_path / "run", SyntheticRun(3), connect=client.url)
    assert path.stat().st_size > 0
    deadline = monotonic() + 10
    while not client.get_state().views and monotonic() < deadline:
        sleep(0.2)
    assert {view.name for view in client.get_state().views} >= {"Bottom view", "Scene", "Phase"}


def test_a_window_of_its_own_sees_the_run_while_it_is_saved(tmp_path, monkeypatch):
    """The program is found where its folder is not on the PATH; here it draws into memory instead."""
    program = tmp_path / "rerun"
    program.write_text(f'#!/bin/sh\nexec {live.program()} --headless "$@"\n')
    program.chmod(0o755)
    monkeypatch.setattr(live, "program", lambda: program)
    monkeypatch.setattr(live, "WINDOWS", [])
    monkeypatch.setattr(live, "SPAWNED", f"rerun+http://127.0.0.1:{free_port()}/proxy")
    try:
        path = record(tmp_path / "run", SyntheticRun(3), spawn=True)
        assert path.stat().st_size > 0
        window = ViewerClient.connect(live.SPAWNED)
        deadline = monotonic() + 20
        while not window.get_state().views and monotonic() < deadline:
            sleep(0.2)
        assert {view.name for view in window.get_state().views} >= {"Bottom view", "Scene", "Phase"}
    finally:
        for process in live.WINDOWS:
            process.terminate()
            process.wait()
