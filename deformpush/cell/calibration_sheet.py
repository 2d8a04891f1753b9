"""The sheet that a camera is calibrated with: a ChArUco board on A4, as PNG or PDF in true size."""

import struct
import zlib

import cv2
import numpy as np

Array = np.ndarray

COLUMNS, ROWS, SQUARE_MM, MARKER = 7, 10, 25.0, 0.72
"""Squares across and down, their side as printed at full size, and a marker's share of it."""
PAGE_MM = (210, 297)
PX_PER_MM = 10
"""254 dots an inch: every square and every dot of a marker is a whole number of pixels."""


def board(square: float) -> cv2.aruco.CharucoBoard:
    """The board with squares of this side (any unit)."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return cv2.aruco.CharucoBoard((COLUMNS, ROWS), square, MARKER * square, dictionary)


def corners(square: float) -> Array:
    """Inner corners `(N, 2)` of the board about its middle, x as one reads, y up the page."""
    half = np.array([COLUMNS, ROWS]) * square / 2
    return (np.asarray(board(square).getChessboardCorners(), float)[:, :2] - half) * (1, -1)


def find(picture: Array) -> tuple[Array, Array]:
    """Inner corners of the sheet in a picture `(H, W, 3)`: their numbers `(n,)` and pixels `(n, 2)`."""
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    px, numbers, _, _ = cv2.aruco.CharucoDetector(board(1.0)).detectBoard(grey)
    if numbers is None:
        return np.zeros(0, int), np.zeros((0, 2))
    return np.asarray(numbers).ravel(), np.asarray(px, float).reshape(-1, 2)


def page() -> Array:
    """The page `(H, W)` uint8, `PX_PER_MM` pixels a millimetre."""
    wide, high = (side * PX_PER_MM for side in PAGE_MM)
    across, down = (round(n * SQUARE_MM * PX_PER_MM) for n in (COLUMNS, ROWS))
    sheet = np.full((high, wide), 255, np.uint8)
    left, top = (wide - across) // 2, 15 * PX_PER_MM
    sheet[top : top + down, left : left + across] = board(SQUARE_MM).generateImage((across, down))
    lines = (
        f"deformpush: ChArUco {COLUMNS} x {ROWS}, DICT_4X4_50, {COLUMNS * SQUARE_MM:g} mm wide, "
        f"{ROWS * SQUARE_MM:g} mm high on A4. Print it without scaling, glue it",
        "flat on something stiff, and measure its height. A tenth of that goes to --square of",
        f"see --calibrate: {SQUARE_MM:g} mm if the printer kept to it.",
    )
    for n, line in enumerate(lines):
        at = left, top + down + (n + 1) * 75
        cv2.putText(sheet, line, at, cv2.FONT_HERSHEY_SIMPLEX, 1.0, 0, 2, cv2.LINE_AA)
    return sheet


def png(sheet: Array) -> bytes:
    """A PNG of the page that says how large it is."""
    data = cv2.imencode(".png", sheet)[1].tobytes()
    density = struct.pack(">IIB", PX_PER_MM * 1000, PX_PER_MM * 1000, 1)  # pixels a metre
    chunk = struct.pack(">I", len(density)) + b"pHYs" + density
    header = 33  # signature and IHDR, behind which it must stand
    return data[:header] + chunk + struct.pack(">I", zlib.crc32(chunk[4:])) + data[header:]


def pdf(sheet: Array) -> bytes:
    """A PDF of one page that the sheet fills."""
    wide, high = (side * 72 / 25.4 for side in PAGE_MM)
    image = zlib.compress(sheet.tobytes(), 9)
    drawing = f"q {wide:.3f} 0 0 {high:.3f} 0 0 cm /Sheet Do Q".encode()
    described = (
        f"/Type /XObject /Subtype /Image /Width {sheet.shape[1]} /Height {sheet.shape[0]} "
        "/ColorSpace /DeviceGray /BitsPerComponent 8 /Filter /FlateDecode"
    )
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {wide:.3f} {high:.3f}] /Contents 4 0 R "
        "/Resources << /XObject << /Sheet 5 0 R >> >> >>".encode(),
        b"<< /Length %d >>\nstream\n%b\nendstream" % (len(drawing), drawing),
        b"<< %b /Length %d >>\nstream\n%b\nendstream" % (described.encode(), len(image), image),
    ]
    out, places = bytearray(b"%PDF-1.4\n"), []
    for number, text in enumerate(objects, start=1):
        places.append(len(out))
        out += b"%d 0 obj\n%b\nendobj\n" % (number, text)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    size = len(objects) + 1
    end = b"xref\n0 %d\n0000000000 65535 f \n%btrailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n"
    return bytes(out) + end % (size, table, size, len(out))
