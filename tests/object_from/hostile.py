"""Files that strangers may send: each with the line that refuses it."""

import struct
import zlib
from collections.abc import Callable

import cv2
import numpy as np

SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">{}</svg>'
RECT = '<rect x="10" y="10" width="80" height="50"/>'

BLOCKS = (
    "0 SECTION 2 BLOCKS 0 BLOCK 8 0 2 B 70 0 10 0 20 0 3 B 0 CIRCLE 8 0 10 0 20 0 40 5 0 ENDBLK 8 0 0 ENDSEC "
    "0 SECTION 2 ENTITIES 0 INSERT 8 0 2 B 10 0 20 0 70 30000 71 30000 44 1 45 1 0 ENDSEC 0 EOF"
)
"""A DXF of one circle, shown 900 million times."""


def png(width: int, height: int, data: bytes = b"") -> bytes:
    """A PNG whose head promises so many grey pixels."""

    def chunk(name: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
        )

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def picture(image: np.ndarray, kind: str = ".png") -> bytes:
    """A picture as a file."""
    return bytes(cv2.imencode(kind, image)[1].tobytes())


def grey(value: int = 128, noise: float = 0.0) -> np.ndarray:
    """A plain picture."""
    rng = np.random.default_rng(0)
    return np.clip(value + rng.normal(0, noise, (120, 160, 3)), 0, 255).astype(np.uint8)


def spread(*, left: bool) -> np.ndarray:
    """A dark blob in the middle, or one that the picture cuts."""
    image = grey(200, 2)
    image[40:80, 0 if left else 50 : 110] = 30
    return image


def dxf(*entities: str, unit: int = 4) -> bytes:
    """A DXF of these entities, rows separated by spaces."""
    rows = [
        "0 SECTION 2 HEADER 9 $ACADVER 1 AC1015 9 $INSUNITS 70",
        str(unit),
        "0 ENDSEC 0 SECTION 2 ENTITIES",
        *entities,
    ]
    return "\n".join(" ".join([*rows, "0 ENDSEC 0 EOF"]).split()).encode()


def laughs() -> str:
    """Entities that would grow to a billion."""
    lines = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 10))
    return f'<?xml version="1.0"?><!DOCTYPE svg [<!ENTITY l0 "ha">{lines}]><svg><text>&l9;</text></svg>'


def scribble(points: int) -> bytes:
    """A line that runs here and there."""
    rng = np.random.default_rng(0)
    return "\n".join(f"{x:.3f},{y:.3f}" for x, y in rng.uniform(0, 200, (points, 2))).encode()


HOSTILE: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "no picture": ("a.png", lambda: b"GIF89a" + bytes(100), "neither PNG nor JPEG"),
    "empty": ("a.jpg", lambda: b"", "is empty"),
    "a bomb": (
        "a.png",
        lambda: png(100_000, 100_000, zlib.compress(bytes(10**6))),
        "100000 x 100000 pixels, 1 to 12000",
    ),
    "a lying head": (
        "a.png",
        lambda: png(500, 500, zlib.compress(bytes(100))),
        "(damaged, cannot be decoded|shows nothing|nothing in it)",
    ),
    "a broken stream": (
        "a.png",
        lambda: png(500, 500, b"x" * 100),
        "(damaged, cannot be decoded|shows nothing|nothing in it)",
    ),
    "half a picture": (
        "a.png",
        lambda: picture(spread(left=False))[:900],
        "(damaged|nothing in it|shows nothing)",
    ),
    "half a JPEG": (
        "a.jpg",
        lambda: picture(grey(), ".jpg")[:300],
        "(neither PNG nor JPEG|no JPEG|damaged|nothing in it)",
    ),
    "tiny": ("a.png", lambda: picture(grey()[:8, :8]), "8 x 8 pixels, 16 a side"),
    "plain": ("a.png", lambda: picture(grey(128, 3)), "nothing in it stands out"),
    "cut": ("a.png", lambda: picture(spread(left=True)), "reaches the rim of the picture"),
    "entities": ("a.svg", lambda: laughs().encode(), "declares XML entities"),
    "an entity from outside": (
        "a.svg",
        lambda: b'<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]><svg><text>&x;</text></svg>',
        "declares XML entities",
    ),
    "entities in UTF-16": ("a.svg", lambda: laughs().encode("utf-16"), "declares XML entities"),
    "clones": ("a.svg", lambda: SVG.format('<use href="#a"/>').encode(), "holds clones"),
    "deep": (
        "a.svg",
        lambda: SVG.format("<g>" * 5000 + "</g>" * 5000).encode(),
        "more than 20000 elements or 100",
    ),
    "no SVG": ("a.svg", lambda: b"<html><body/></html>", "is no SVG; its root is html"),
    "no XML": ("a.svg", lambda: b"<svg><path", "is no XML"),
    "nothing drawn": ("a.svg", lambda: SVG.format("").encode(), "holds no closed line"),
    "a bad path": (
        "a.svg",
        lambda: SVG.format('<path d="M 0 0 L 1e999 4 L 3 3 z"/>').encode(),
        "(a coordinate is not|cannot be read|holds no closed)",
    ),
    "many arcs": (
        "a.svg",
        lambda: SVG.format(f'<path d="M 0 0 {"a 5 5 0 1 0 1 1 " * 100_000}z"/>').encode(),
        "has paths of more than 1000000 letters",
    ),
    "thousands of arcs": (
        "a.svg",
        lambda: SVG.format(f'<path d="M 0 0 {"a 5 5 0 1 0 1 1 " * 11_000}z"/>').encode(),
        "has more than 10000 segments",
    ),
    "too large": ("a.svg", lambda: SVG.format(RECT + " " * 6_000_000).encode(), "is larger than 5 MB"),
    "no DXF": ("a.dxf", lambda: b"hello\nworld\n", "(cannot be read as DXF|holds no line)"),
    "half a DXF": ("a.dxf", lambda: dxf("0 LINE 8 0 10 0 20")[:-30], "(cannot be read as DXF|holds no line)"),
    "an empty DXF": ("a.dxf", dxf, "holds no line"),
    "a DXF of an open line": (
        "a.dxf",
        lambda: dxf("0 LINE 8 0 10 0 20 0 11 100 21 0"),
        "(holds no closed line|no line)",
    ),
    "a block of blocks": (
        "a.dxf",
        lambda: BLOCKS.replace(" ", "\n").encode(),
        "draws more than 5000 entities",
    ),
    "a huge spline": (
        "a.dxf",
        lambda: dxf("0 CIRCLE 8 0 10 0 20 0 40 1e300"),
        "(not a finite number|holds no|cannot be)",
    ),
    "a lying STL": ("a.stl", lambda: bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(500), "is no STL"),
    "a short STL": ("a.stl", lambda: b"binary", "is no STL"),
    "an STL of words": (
        "a.stl",
        lambda: b"solid a\nfacet normal zero\nendsolid a\n",
        "(cannot be read as STL|has 0)",
    ),
    "a flat STL": ("a.stl", lambda: bytes(80) + struct.pack("<I", 1) + bytes(50), "covers no area"),
    "an STL of nan": (
        "a.stl",
        lambda: bytes(80) + struct.pack("<I12fH", 1, *([float("nan")] * 12), 0),
        "(not a finite number|cannot be|has 0)",
    ),
    "too many triangles": (
        "a.stl",
        lambda: bytes(80) + struct.pack("<I", 400_000) + bytes(np.random.default_rng(0).bytes(50 * 400_000)),
        "has 400000 triangles",
    ),
    "an OBJ of words": ("a.obj", lambda: b"hello\n", "is no OBJ"),
    "an OBJ of no faces": ("a.obj", lambda: b"v 0 0 0\nv 1 0 0\n", "(cannot be read as OBJ|has 0)"),
    "an OBJ that reaches out": (
        "a.obj",
        lambda: b"mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nf 1 2 9\n",
        "(cannot be read as OBJ|has 0|covers no area)",
    ),
    "a CSV of words": ("a.csv", lambda: b"x,y\n1,2\nhello\n", "line 3: must be two numbers"),
    "a CSV of three columns": ("a.csv", lambda: b"1,2,3\n4,5,6\n", "line 1: must be two numbers"),
    "a CSV of two points": ("a.csv", lambda: b"1,2\n3,4\n", "holds no closed line"),
    "a CSV of infinity": ("a.csv", lambda: b"1,2\n3,inf\n7,8\n", "not a finite number"),
    "a CSV of bytes": ("a.csv", lambda: bytes(range(128, 256)), "is no text in UTF-8"),
    "a scribble": ("a.csv", lambda: scribble(20_000), "has lines .* times as long as it is large"),
    "a short scribble": ("a.csv", lambda: scribble(300), "(outline|cell): "),
    "a line": ("a.csv", lambda: b"0,0\n100,0\n200,0\n", "covers no area"),
    "in metres": ("a.csv", lambda: b"0,0\n0.2,0\n0.2,0.1\n0,0.1\n", "outline: is 0.0002 m long"),
    "no JSON": ("a.geojson", lambda: b"{", "is no JSON"),
    "deep JSON": ("a.geojson", lambda: b"[" * 100_000, "is no JSON"),
    "no polygon": ("a.geojson", lambda: b'{"type": "Point", "coordinates": [1, 2]}', "holds no Polygon"),
    "a list": ("a.geojson", lambda: b"[1, 2]", "is no GeoJSON"),
    "odd coordinates": (
        "a.geojson",
        lambda: b'{"type": "Polygon", "coordinates": [[[1, 2], ["a", {}], 7]]}',
        "a ring must be a list of points",
    ),
    "no coordinates": ("a.geojson", lambda: b'{"type": "Polygon"}', "must be a list of rings"),
    "another kind": ("a.pdf", lambda: b"%PDF", "must end in .png, "),
}
"""By what it is: name of the file, what makes its bytes, and a pattern of the line."""
