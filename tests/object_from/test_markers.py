"""The scale of a picture from a printed marker; a slanted one straightened out by a sheet of them."""

import cv2
import numpy as np
import pytest
import shapely

from deformpush.errors import UserError
from deformpush.outlines.picture import Scale
from tests.object_from.making import apart, centred, made, write

SHOWN = np.array([(60, 60), (220, 60), (220, 110), (110, 110), (110, 220), (60, 220)], float)
"""An L (mm, y down)."""
PX = 3  # of a millimetre
TRUE = shapely.Polygon(SHOWN * (1, -1)).buffer(0.5 / PX, join_style="mitre")
"""As it is drawn: the pixels on its rim are coloured too."""


def table() -> np.ndarray:
    """A table 500 x 300 mm, the L on it: RGB."""
    image = np.full((300 * PX, 500 * PX, 3), (150, 160, 150), np.uint8)
    cv2.fillPoly(image, [np.round(SHOWN * PX).astype(np.int32)], (60, 70, 130), cv2.LINE_AA)
    return image


def lay(image: np.ndarray, print_: np.ndarray, x: int, y: int) -> None:
    """Put a print on the table, its upper left corner at x, y (mm)."""
    h, w = print_.shape[:2]
    image[y * PX : y * PX + h, x * PX : x * PX + w] = print_[..., None]


def with_marker(side: int = 50) -> np.ndarray:
    image = table()
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    lay(image, np.full(((side + 20) * PX, (side + 20) * PX), 250, np.uint8), 380, 60)
    lay(image, cv2.aruco.generateImageMarker(known, 3, side * PX), 390, 70)
    return image


def with_sheet(square: int = 25, marker: int = 18) -> np.ndarray:
    image = table()
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((6, 8), square, marker, known)
    lay(image, board.generateImage((6 * square * PX + 40, 8 * square * PX + 40), marginSize=20), 300, 40)
    return image


def photographed(image: np.ndarray, slant: float) -> np.ndarray:
    """The table as a camera sees it that looks at a slant, half as fine, with noise."""
    h, w = image.shape[:2]
    to = np.array([(slant * w, 0), (w - slant * w, slant * h), (w, h), (0, h - slant * h / 2)], np.float32)
    flat = np.array([(0, 0), (w, 0), (w, h), (0, h)], np.float32)
    half = np.diag([0.5, 0.5, 1.0])
    seen = cv2.warpPerspective(
        cv2.GaussianBlur(image, (0, 0), 1.2),
        half @ cv2.getPerspectiveTransform(flat, to),
        (w // 2, h // 2),
        borderValue=(150, 160, 150),
    )
    return np.clip(seen + np.random.default_rng(0).normal(0, 3, seen.shape), 0, 255).astype(np.uint8)


def test_a_marker_gives_the_scale(tmp_path):
    image = photographed(with_marker(), 0.0)
    one = made(write(tmp_path / "a.png", image), scale=Scale(marker_mm=50))
    found, true = shapely.Polygon(one.overlay.outline), TRUE
    assert found.area == pytest.approx(true.area, rel=0.01)
    assert one.size == pytest.approx(2 * shapely.minimum_bounding_radius(true) / 1e3, rel=0.01)
    assert not [line for line in one.lines if line.startswith("pieces")], "the marker is no piece"


def test_a_picture_at_a_slant_is_refused_with_one_marker_and_straightened_out_with_a_sheet(tmp_path):
    with pytest.raises(UserError, match=r"sides of its marker differ by .*%: it was taken at a slant"):
        made(write(tmp_path / "a.png", photographed(with_marker(), 0.08)), scale=Scale(marker_mm=50))
    one = made(write(tmp_path / "b.png", photographed(with_sheet(), 0.08)), scale=Scale(charuco_mm=25))
    found = centred(one.overlay.outline)
    true = centred(np.array(TRUE.exterior.coords))
    assert found.area == pytest.approx(true.area, rel=0.01)
    assert apart(found, true) < 1.5


def test_a_sheet_of_other_squares_and_markers(tmp_path):
    one = made(write(tmp_path / "a.png", photographed(with_sheet(22, 11), 0.05)), scale=Scale(charuco_mm=22))
    assert shapely.Polygon(one.overlay.outline).area == pytest.approx(TRUE.area, rel=0.01)


def test_where_no_marker_is(tmp_path):
    with pytest.raises(UserError, match="shows no ArUco marker"):
        made(write(tmp_path / "a.png", photographed(table(), 0.0)), scale=Scale(marker_mm=50))
    with pytest.raises(UserError, match=r"shows 1 marker of a ChArUco sheet .*, 6 are needed"):
        made(write(tmp_path / "a.png", photographed(with_marker(), 0.0)), scale=Scale(charuco_mm=25))
