"""What is drawn over the bottom view lies where the camera sees it, at the push it belongs to."""

import cv2
import numpy as np
import pytest
import rerun.blueprint as rrb

from deformpush.record import palette
from deformpush.viewer.bottom_view import around
from tests.record.synthetic import CAMERA, GOAL, SyntheticRun
from tests.viewer.recording import Contents, record


def px(points: np.ndarray, width: int = 480) -> np.ndarray:
    """Where the camera sees points of the table, from the corner of the picture."""
    x, y = ((np.asarray(points) - CAMERA.centre) * CAMERA.scale).T
    return (np.stack([x, -y], -1) + CAMERA.pixels / 2) * width / CAMERA.pixels


def ranges(bounds: rrb.VisualBounds2D) -> list[list[float]]:
    """X and y that are shown."""
    (shown,) = bounds.range.as_arrow_array().to_pylist()
    return [shown["x_range"], shown["y_range"]]


def closed(points: np.ndarray) -> np.ndarray:
    return np.vstack([points, points[:1]])


def test_the_contour_after_each_push_is_drawn(full):
    strips = full.contents.at("/camera/contour", "LineStrips2D:strips")
    assert list(strips) == list(range(13))
    for row in full.rows:
        np.testing.assert_allclose(strips[row.k][0], px(closed(row.view.seen.contour)), atol=1e-3)
    assert full.contents.colours("/camera/contour", "LineStrips2D:colors") == [palette.CONTOUR]


def test_the_goal_is_drawn_once(full):
    strip = full.contents.fixed("/camera/goal", "LineStrips2D:strips")[0]
    np.testing.assert_allclose(strip, px(closed(full.info.target.outline)), atol=1e-3)
    centroid = full.contents.fixed("/camera/goal/centroid", "Points2D:positions")
    np.testing.assert_allclose(centroid, px(GOAL[None, :2]), atol=1e-3)
    assert full.contents.colours("/camera/goal", "LineStrips2D:colors") == [palette.GOAL]


def test_the_trail_holds_every_centroid_so_far(full):
    strips = full.contents.at("/camera/trail", "LineStrips2D:strips")
    centroids = px(np.array([row.view.seen.c for row in full.rows]))
    assert list(strips) == list(range(13))
    for k, strip in strips.items():
        np.testing.assert_allclose(strip[0], centroids[: k + 1], atol=1e-3)
    assert full.contents.colours("/camera/trail", "LineStrips2D:colors") == [palette.TRAIL]


def test_the_next_push_is_drawn_at_the_state_it_is_chosen_in(full):
    starts = full.contents.at("/camera/next_push/start", "Points2D:positions")
    origins = full.contents.at("/camera/next_push/arrow", "Arrows2D:origins")
    vectors = full.contents.at("/camera/next_push/arrow", "Arrows2D:vectors")
    assert list(starts) == list(origins) == list(vectors) == list(range(12))
    for row in full.rows[1:]:
        start, end = px(np.stack([row.action.path.start, row.action.path.end]))
        np.testing.assert_allclose(starts[row.k - 1][0], start, atol=1e-3)
        np.testing.assert_allclose(origins[row.k - 1][0], start, atol=1e-3)
        np.testing.assert_allclose(vectors[row.k - 1][0], end - start, atol=1e-3)
    assert full.contents.colours("/camera/next_push/start", "Points2D:colors") == [palette.NEXT_PUSH]
    assert full.contents.colours("/camera/next_push/arrow", "Arrows2D:colors") == [palette.NEXT_PUSH]


def test_the_effective_contour_is_coloured_by_kappa(full):
    dots = full.contents.at("/camera/effective", "Points2D:positions")
    assert list(dots) == list(range(12))
    for row in full.rows[1:]:
        ends = px(row.action.effective[[0, -1]])
        np.testing.assert_allclose(np.array(dots[row.k - 1])[[0, -1]], ends, atol=1e-3)
        steps = np.linalg.norm(np.diff(dots[row.k - 1], axis=0), axis=1)
        assert len(steps) == 99
        assert steps.max() < 1.1 * np.median(steps), "evenly spaced"
    colours = full.contents.colours("/camera/effective", "Points2D:colors")
    assert (colours[0], colours[-1]) == (palette.ALONG[0], palette.ALONG[-1])
    assert len(colours) == 100


def test_what_belonged_to_a_push_goes_when_it_is_made(full):
    for entity, recursive in (("/camera/next_push", True), ("/camera/effective", False)):
        gone = full.contents.at(entity, "Clear:is_recursive")
        assert gone == {k: [recursive] for k in range(13)}


@pytest.mark.parametrize(("asked", "width"), [(480, 480), (240, 240), (2048, 480)])
def test_drawings_fit_a_picture_of_another_width(tmp_path, asked, width):
    made = SyntheticRun(1)
    rows = made.records()
    contents = Contents(record(tmp_path / "run", made, rows, image_px=asked))
    blob = np.frombuffer(bytes(contents.at("/camera/image", "EncodedImage:blob")[1][0]), np.uint8)
    picture = cv2.imdecode(blob, cv2.IMREAD_COLOR_RGB)
    assert picture.shape == (width, width, 3), "never wider than what the camera saw"
    strip = np.array(contents.at("/camera/contour", "LineStrips2D:strips")[1][0])
    np.testing.assert_allclose(strip, px(closed(rows[1].view.seen.contour), width), atol=1e-3)
    middle = tuple(np.round(strip.mean(0)).astype(int)[::-1])
    assert np.abs(picture[middle].astype(int) - (60, 90, 200)).max() < 12, (
        "the object is where its contour is"
    )


def test_bounds_leave_room_and_end_with_the_picture():
    places = np.array([[0.5, 0.0], [0.6, 0.1]])
    (left, bottom), (right, top) = px(np.array([[0.48, -0.02], [0.62, 0.12]]), 240)
    np.testing.assert_allclose(ranges(around(CAMERA, 240, places, 0.02)), [[left, right], [top, bottom]])
    np.testing.assert_allclose(ranges(around(CAMERA, 240, places, 5.0)), [[0, 240], [0, 240]])
