"""A headless viewer opens the recording and no view reports an error."""

import socket
import subprocess
from pathlib import Path
from time import monotonic, sleep

import cv2
import pytest
import rerun_cli
from rerun.experimental import ViewerClient

from tests.record.synthetic import SyntheticRun, kuka
from tests.record.test_stream import record

DRIVERS = [path for folder in ("/usr/share", "/etc") for path in Path(folder, "vulkan/icd.d").glob("*.json")]

pytestmark = [
    pytest.mark.screen,
    pytest.mark.skipif(not DRIVERS, reason="no Vulkan driver (Debian: mesa-vulkan-drivers)"),
]


@pytest.fixture(scope="module")
def viewer():
    """A viewer without a window, on a free port, that is gone afterwards."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    program = str(Path(rerun_cli.__file__).with_name("rerun"))
    command = [
        program,
        "--headless",
        "--window-size",
        "1600x900",
        "--port",
        str(port),
        "--hide-welcome-screen",
    ]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            deadline = monotonic() + 30
            while monotonic() < deadline:
                try:
                    socket.create_connection(("127.0.0.1", port), timeout=1).close()
                    break
                except OSError:
                    sleep(0.2)
            yield ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
        finally:
            process.terminate()


@pytest.mark.parametrize(
    ("options", "views"),
    [
        ({}, 15),
        ({"scene": False, "motion": False, "image_px": 240}, 14),
        ({"scene": False, "motion": False, "maps": False}, 11),
    ],
    ids=["full", "light", "least"],
)
def test_no_view_reports_an_error(viewer, tmp_path, options, views):
    path = record(tmp_path / "run", SyntheticRun(12, urdf=kuka()), **options)
    viewer.open(str(path))
    for at in ({"sequence": 0}, {"sequence": 11}):
        viewer.set_time("push", **at, play_state="paused")
        viewer.save_screenshot(str(tmp_path / "view.png"))
        state = viewer.get_state()
        assert {view.name: list(view.reports) for view in state.views if view.reports} == {}
    assert len(state.views) == views
    picture = cv2.imread(str(tmp_path / "view.png"))
    assert picture.shape == (900, 1600, 3)
    assert picture.std() > 20
    viewer.close("all")


def test_a_live_viewer_sees_the_run_while_it_is_saved(viewer, tmp_path):
    path = record(tmp_path / "run", SyntheticRun(3), connect=viewer.url)
    assert path.stat().st_size > 0
    deadline = monotonic() + 10
    while not viewer.get_state().views and monotonic() < deadline:
        sleep(0.2)
    assert {view.name for view in viewer.get_state().views} >= {"Bottom view", "Scene", "Phase"}
