"""Draws the files of this folder: what `python -m deformpush object from FILE` is shown with.

python docs/examples/draw.py
"""

from pathlib import Path

import cv2
import numpy as np

HERE = Path(__file__).parent
FINE = 4  # drawn so many times larger than it is kept
PX = 2 * FINE  # of a millimetre
WIDTH, HEIGHT = 400, 220  # mm
MARKER = 40  # mm
Array = np.ndarray


def main() -> None:
    """Write all of them."""
    cv2.imwrite(str(HERE / "fish.png"), fish(), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    (HERE / "ring.svg").write_text(ring(), encoding="utf-8")
    (HERE / "ell.dxf").write_text(ell(), encoding="utf-8")
    (HERE / "dough_round.csv").write_text(dough(), encoding="utf-8")


def fish() -> Array:
    """A fish on a board, with a printed marker beside it: BGR, 0.5 mm a pixel."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[0 : HEIGHT * PX, 0 : WIDTH * PX].astype(np.float32) / PX
    image = np.full((*x.shape, 3), (150, 172, 176), np.float32)
    grain = cv2.GaussianBlur(rng.normal(0, 1, x.shape).astype(np.float32), (0, 0), 40, sigmaY=3)
    image += (grain / grain.std() * 2.5)[..., None]

    shape = [body(), *fins()]
    under = np.zeros(x.shape, np.float32)
    for part in shape:
        fill(under, part, 1.0)
    shadow = cv2.GaussianBlur(np.roll(under, (2 * PX, 1 * PX), axis=(0, 1)), (0, 0), 3 * PX)
    image *= (1 - 0.1 * shadow)[..., None]

    for part in fins():
        rays = 0.85 + 0.15 * np.sin((x * 0.9 + 1.3 * np.abs(y - 110)) * 1.4)
        paint(image, part, np.stack([88 * rays, 96 * rays, 104 * rays], axis=-1))
    back = np.clip((y - 72) / 70, 0, 1)[..., None]  # dark above, bright below
    scales = 1 + 0.05 * np.sin(x * 1.9 + np.sin(y * 1.6)) * np.sin(y * 1.6)
    skin = (np.array((70, 74, 66)) * (1 - back) + np.array((206, 214, 214)) * back) * scales[..., None]
    gloss = np.exp(-(((y - 96 - 0.02 * (x - 170)) / 5) ** 2))[..., None] * 26
    paint(image, body(), skin + gloss)
    gill = np.column_stack([116 + 5 * np.sin(np.linspace(0.3, 2.8, 30)), np.linspace(86, 132, 30)])
    cv2.polylines(image, [px(gill)], False, (70, 76, 80), PX, cv2.LINE_AA)
    for radius, colour in ((6, (210, 218, 220)), (5, (60, 66, 70)), (2.6, (18, 18, 20))):
        cv2.circle(image, px(np.array([[93, 101]]))[0].tolist(), round(radius * PX), colour, -1, cv2.LINE_AA)

    paper = np.full(((MARKER + 16) * PX, (MARKER + 16) * PX), 244, np.uint8)
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    paper[8 * PX : -8 * PX, 8 * PX : -8 * PX] = np.clip(
        cv2.aruco.generateImageMarker(known, 7, MARKER * PX), 28, 244
    )
    turn = cv2.getRotationMatrix2D((28 * PX, 28 * PX), 9, 1)
    turn[:, 2] += (326 * PX, 152 * PX)
    size = (WIDTH * PX, HEIGHT * PX)
    here = cv2.warpAffine(np.ones_like(paper), turn, size)[..., None]
    image = np.where(here, cv2.warpAffine(paper, turn, size)[..., None], image)

    light = 1.06 - 0.16 * (x / WIDTH - 0.2) ** 2 - 0.14 * (y / HEIGHT) ** 2
    image = cv2.GaussianBlur(image * light[..., None], (0, 0), 0.7 * FINE)
    image = cv2.resize(image, (size[0] // FINE, size[1] // FINE), interpolation=cv2.INTER_AREA)
    return np.clip(image + rng.normal(0, 2.0, image.shape), 0, 255).round().astype(np.uint8)


def body() -> Array:
    """Nose to the left, tail to the right (mm)."""
    upper = [(70, 111), (82, 97), (100, 85), (130, 76), (165, 74), (205, 80), (245, 93), (270, 101)]
    tail = [(286, 92), (306, 72), (302, 96), (298, 109), (303, 124), (309, 148), (286, 128)]
    lower = [(270, 119), (245, 126), (205, 138), (165, 144), (130, 143), (100, 135), (82, 125)]
    return smooth(np.array(upper + tail + lower, float))


def fins() -> list[Array]:
    """Above and below."""
    return [
        smooth(np.array([(140, 80), (156, 60), (180, 57), (206, 66), (214, 86), (180, 90)], float)),
        smooth(np.array([(150, 138), (163, 158), (178, 162), (180, 150), (176, 136)], float)),
        smooth(np.array([(222, 130), (236, 147), (250, 148), (249, 136), (244, 122)], float)),
    ]


def smooth(corners: Array) -> Array:
    """A closed curve through corners (Catmull-Rom), ten points from one to the next."""
    t = np.linspace(0, 1, 10, endpoint=False)[:, None]
    before, after, beyond = (
        np.roll(corners, 1, axis=0),
        np.roll(corners, -1, axis=0),
        np.roll(corners, -2, axis=0),
    )
    parts = [
        0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - 3 * c + d - a) * t**3)
        for a, b, c, d in zip(before, corners, after, beyond, strict=True)
    ]
    return np.concatenate(parts)


def px(points: Array) -> Array:
    """Millimetres to whole pixels."""
    return np.round(points * PX).astype(np.int32)


def fill(share: Array, polygon: Array, value: float) -> None:
    """Set a polygon (mm) in a raster."""
    cv2.fillPoly(share, [px(polygon)], value, cv2.LINE_AA)


def paint(image: Array, polygon: Array, colours: Array) -> None:
    """Lay colours over a polygon (mm), darker towards its rim."""
    share = np.zeros(image.shape[:2], np.float32)
    fill(share, polygon, 1.0)
    round_ = cv2.GaussianBlur(share, (0, 0), 5 * PX)
    image += share[..., None] * (colours * (0.72 + 0.28 * round_[..., None]) - image)


def ring() -> str:
    """A ring sector of 270 degrees, 200 mm across, in an SVG that states millimetres."""
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" width="220mm" height="220mm" viewBox="-110 -110 220 220">\n'
        '  <path fill="#d8b48a" d="M 100 0 A 100 100 0 1 0 0 100 L 0 50 A 50 50 0 1 1 50 0 Z"/>\n'
        "</svg>\n"
    )


def ell() -> str:
    """An L of six lines, arms 160 mm long and 50 mm wide, in a DXF that states millimetres."""
    corners = [(0, 0), (160, 0), (160, 50), (50, 50), (50, 160), (0, 160)]
    rows = ["0", "SECTION", "2", "HEADER", "9", "$INSUNITS", "70", "4", "0", "ENDSEC"]
    rows += ["0", "SECTION", "2", "ENTITIES"]
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        rows += ["0", "LINE", "8", "0", "10", x0, "20", y0, "11", x1, "21", y1]
    return "\n".join(map(str, [*rows, "0", "ENDSEC", "0", "EOF"])) + "\n"


def dough() -> str:
    """A ball of dough pressed flat by hand: nearly round, 140 mm across, as points in millimetres."""
    angle = np.arange(48) * 2 * np.pi / 48
    r = 70 + 1.6 * np.cos(2 * angle + 0.5) + 0.9 * np.cos(3 * angle) + 0.6 * np.cos(5 * angle + 2)
    return "x,y\n" + "".join(
        f"{x:.1f},{y:.1f}\n" for x, y in zip(r * np.cos(angle), r * np.sin(angle), strict=True)
    )


if __name__ == "__main__":
    main()
