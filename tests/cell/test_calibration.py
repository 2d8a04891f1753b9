"""A camera with a lens, above or below the table: found from the sheet, and its pictures rectified."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from benchmarks.real_camera import SIZE, camera, sheet_views
from benchmarks.rendering import Shot
from deformpush.cell import calibration_sheet as sheet
from deformpush.cell.calibrated import CalibratedCamera, WrongPictureError
from deformpush.cell.calibration import CalibrationError, calibrate
from deformpush.cell.camera import Camera
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import resample
from tests.pictures import RECT, centroid, picture, placed

SQUARE, AT = 0.025, (0.58, 0.02)
SHOT = Shot(noise=3, blur=0.7)
PLACES = {"above": (0.5, 0.12, 0.8), "below": (0.62, 0.1, -0.8)}
EYE = config.build(compose([]).contour)


@pytest.fixture(scope="module", params=["below", pytest.param("above", marks=pytest.mark.slow)])
def found(request):
    """The true camera, what it took of the sheet, and what is made of that."""
    true = camera(PLACES[request.param], (0.58, 0.0, 0.0))
    views = sheet_views(true, 6, SQUARE, AT, SHOT)
    return true, views, calibrate(views, SQUARE, AT, 0.0, request.param, 50.0)


def field(eye: Camera) -> np.ndarray:
    """Table points all over the picture `(N, 2)` (m)."""
    steps = np.linspace(-0.5, 0.5, 9) * eye.field
    return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) + eye.centre


@pytest.mark.parametrize("high", [0.0, 0.01])
def test_every_place_in_the_picture_is_known_to_under_a_millimetre(found, high):
    true, _, calibration = found
    points = field(calibration.camera)
    raw = replace(true, plane_z=high).to_raw(points)
    off = np.linalg.norm(replace(calibration.camera, plane_z=high).from_raw(raw) - points, axis=1)
    assert off.max() < 1e-3
    assert np.sqrt(np.mean(off**2)) < 0.4e-3
    assert calibration.camera.field > 0.6
    assert calibration.used == 6


def test_the_error_that_is_told_is_of_the_size_of_the_true_one(found):
    true, _, calibration = found
    points = field(calibration.camera)
    off = np.linalg.norm(calibration.camera.from_raw(true.to_raw(points)) - points, axis=1)
    assert 0.3 * off.max() < calibration.rim_mm / 1e3 < 6 * off.max()
    assert 0 < calibration.table_mm < calibration.worst_mm < 0.5
    assert calibration.px < 0.2


def test_an_object_is_where_it_is(found):
    true, _, calibration = found
    eye = replace(calibration.camera, plane_z=0.01)
    truth = placed(RECT, eye.centre[0] + 0.1, eye.centre[1] - 0.12, 33)
    ideal = Camera(eye.centre, eye.field, eye.distance, 1600, plane_z=0.01)
    taken = replace(true, centre=eye.centre, field=eye.field, pixels=1600, plane_z=0.01)
    seen = EYE.observe(eye.rectified(SHOT.of(taken.through_lens(picture(ideal, truth)))), eye)
    fine = resample(truth, 2000)
    assert np.linalg.norm(seen.contour[:, None] - fine, axis=2).min(axis=1).max() < 1e-3
    np.testing.assert_allclose(seen.c, centroid(truth), atol=0.5e-3)
    assert np.degrees(seen.theta) == pytest.approx(33, abs=0.3)


def test_into_the_lens_and_out_of_it_is_the_same_picture(found):
    eye = found[2].camera
    drawn = picture(eye, placed(RECT, eye.centre[0], eye.centre[1], 20))
    back = eye.rectified(eye.through_lens(drawn))
    assert np.mean(np.abs(back.astype(int) - drawn).max(axis=2) > 100) < 1e-3
    with pytest.raises(
        WrongPictureError, match=r"^the picture has 700 x 500 pixels, the camera was calibrated"
    ):
        eye.rectified(np.zeros((500, 700, 3), np.uint8))


def bent(view: np.ndarray, px: float) -> np.ndarray:
    """A picture with waves."""
    x, y = np.meshgrid(*[np.arange(side, dtype=np.float32) for side in SIZE])
    waves = (x + px * np.sin(y / 60)).astype(np.float32), (y + px * np.sin(x / 50)).astype(np.float32)
    return cv2.remap(view, *waves, cv2.INTER_LINEAR)


CANNOT = {
    "one": (lambda views: views[:3], r"^3 of 3 pictures show 12 corners of the sheet or more, 4 are needed"),
    "none": (
        lambda views: [0 * view for view in views],
        r"^the first picture, with the sheet on the table, shows 0",
    ),
    "two sizes": (
        lambda views: [views[0], views[1][:-1]],
        r"must be of one size \(px\), these are: 960 x 720, 960 x 7",
    ),
    "no tilt": (
        lambda views: [views[0]] * 5,
        r"^the sheet is tilted by 0 degrees between pictures at most: tilt it",
    ),
    "a bent sheet": (
        lambda views: [bent(view, 4) for view in views],
        r"^no lens fits the pictures: \d\.\d px off; is the sheet flat, and one camera used\?",
    ),
}


@pytest.mark.parametrize("case", CANNOT)
def test_pictures_that_tell_no_lens_are_refused(found, case):
    harm, message = CANNOT[case]
    with pytest.raises(CalibrationError, match=message):
        calibrate(harm(found[1]), SQUARE, AT, 0.0, "above", 50.0)


def test_pictures_with_two_zooms_have_a_large_error(found):
    views = found[1][:3] + [cv2.resize(view[120:600, 160:800], SIZE) for view in found[1]]
    assert calibrate(views, SQUARE, AT, 0.0, "above", 50.0).rim_mm > 5


def test_a_wrong_size_of_the_squares_is_a_wrong_height(found):
    with pytest.raises(
        CalibrationError, match=r"^the camera would stand 25\.?\d* m from the table; is --square"
    ):
        calibrate(found[1], 0.8, AT, 0.0, "above", 50.0)


def test_a_camera_that_looks_away_is_refused():
    with pytest.raises(ValueError, match=r"^turn: the camera looks away from the table"):
        camera((0.5, 0.0, 0.8), (0.5, 0.0, 1.8))


def test_the_page_is_a4_in_true_size():
    page = sheet.page()
    assert page.shape == (2970, 2100)
    data = sheet.png(page)
    at = data.index(b"pHYs")
    assert [int.from_bytes(data[at + n : at + n + 4], "big") for n in (4, 8)] == [10_000, 10_000]
    np.testing.assert_array_equal(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE), page)
    numbers, px = sheet.find(cv2.cvtColor(page, cv2.COLOR_GRAY2RGB))
    assert len(numbers) == (sheet.COLUMNS - 1) * (sheet.ROWS - 1)
    steps = np.diff(px.reshape(sheet.ROWS - 1, sheet.COLUMNS - 1, 2), axis=1)[..., 0]
    np.testing.assert_allclose(steps, sheet.SQUARE_MM * sheet.PX_PER_MM, atol=0.5)


def test_the_pdf_is_one_page_of_a4():
    data = sheet.pdf(sheet.page())
    assert data.startswith(b"%PDF-1.4")
    assert data.rstrip().endswith(b"%%EOF")
    assert b"/MediaBox [0 0 595.276 841.890]" in data
    table = int(data.rsplit(b"startxref\n", 1)[1].split()[0])
    places = [int(line[:10]) for line in data[table:].splitlines()[3:8]]
    assert [data[place : place + 7] for place in places] == [b"%d 0 obj" % n for n in range(1, 6)]


def test_a_calibrated_camera_is_a_camera():
    assert issubclass(CalibratedCamera, Camera)
    plain = Camera((0.5, 0.0), 0.5, 1.0, 64)
    assert plain.rectified(image := np.zeros(plain.shape, np.uint8)) is image is plain.through_lens(image)
