"""What a picture of a recording needs to know before it is drawn; pictures themselves: `test_screen`."""

import pytest

from deformpush.errors import UserError
from deformpush.viewer import headless


def test_the_last_push_is_found_in_the_recording(full):
    assert headless.last_push(full.path) == 12


def test_without_a_driver_a_picture_is_refused_in_one_line(full, tmp_path, monkeypatch):
    monkeypatch.setattr(headless, "DRIVERS", [tmp_path])
    assert not headless.has_driver()
    with pytest.raises(UserError, match=r"^a picture without a display needs a Vulkan driver"):
        headless.screenshot([full.path], tmp_path / "picture.png", 1)


def test_a_port_is_free():
    assert 0 < headless.free_port() < 65536
