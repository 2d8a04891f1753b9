"""A headless viewer opens the recording and no view reports an error."""

from time import monotonic, sleep

import cv2
import pytest

from deformpush.record.headless import NEEDS, complaints, has_driver, viewer
from tests.record.synthetic import SyntheticRun, kuka
from tests.record.test_stream import record

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
        ({}, 15),
        ({"scene": False, "motion": False, "image_px": 240}, 14),
        ({"scene": False, "motion": False, "maps": False}, 11),
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
