"""A bottom view on a page shows picture, goal, contour, trail and next push where they are."""

import base64

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.record.poses import read_pictures, read_poses
from deformpush.study import bottom_view_svg
from deformpush.study.chart import css
from tests.study import html_tree

RUN = "acq.w=1,seed=0"


@pytest.fixture(scope="module")
def poses(sweep):
    return read_poses(sweep / RUN / "contours.npz")


@pytest.fixture(scope="module")
def pictures(sweep):
    return read_pictures(sweep / RUN / "views.npz")


def pixels(node) -> np.ndarray:
    return np.array([point.split(",") for point in node.attributes["points"].split()], float)


@pytest.mark.parametrize("k", [0, 12])
def test_a_still_view_shows_the_state_after_a_push(poses, pictures, k):
    seen = bottom_view_svg.square_around([poses])
    tree = html_tree.read(bottom_view_svg.still(poses, k, pictures[k], seen))
    shown = {node.attributes["stroke"]: node for node in tree.all() if "points" in node.attributes}
    where = {palette.GOAL: poses.goal_outline, palette.CONTOUR: poses.contours[k]}
    where[palette.TRAIL] = poses.centroids[: k + 1]
    assert list(shown) == [css(colour) for colour in where]
    for colour, points in where.items():
        np.testing.assert_allclose(pixels(shown[css(colour)]), poses.camera.to_picture(points), atol=0.051)
    image = tree.one("image").attributes
    assert base64.b64decode(image["href"].partition(",")[2]) == pictures[k]
    assert image["width"] == image["height"] == str(poses.camera.pixels)
    assert not any("id" in node.attributes for node in tree.all()), "many of them share a page"


def test_a_moving_view_has_a_name_for_whatever_moves(poses, pictures):
    tree = html_tree.read(bottom_view_svg.moving(poses, pictures[0], (0, 0, 10, 10)))
    names = [node.attributes["id"] for node in tree.all() if "id" in node.attributes]
    assert names == ["picture", "contour", "trail", "push", "start", "arrow"]
    assert tree.one("circle").attributes["fill"] == css(palette.NEXT_PUSH)
    assert tree.one("path").attributes["stroke"] == css(palette.NEXT_PUSH)
    assert tree.one("svg").attributes["viewbox"] == "0 0 10 10"


def test_the_square_holds_all_that_was_and_shall_be(poses, sweep):
    other = read_poses(sweep / "acq.w=2,seed=1" / "contours.npz")
    left, top, width, height = bottom_view_svg.square_around([poses, other])
    assert width == height
    for one in (poses, other):
        places = np.concatenate([one.goal_outline, *one.contours, one.starts[1:]])
        x, y = one.camera.to_picture(places).T
        assert left < x.min() < x.max() < left + width
        assert top < y.min() < y.max() < top + height
