"""One L in every format: each reader finds it, and takes the unit from the file where it states one."""

import json
import struct
import sys
from collections.abc import Callable

import numpy as np
import pytest

from deformpush.errors import UserError
from deformpush.outlines.drawing import METRES
from deformpush.outlines.picture import Scale
from deformpush.outlines.read import read
from tests.object_from.hostile import dxf
from tests.object_from.making import apart, centred, made, polygon

CORNERS = np.array([(0, 0), (160, 0), (160, 50), (50, 50), (50, 160), (0, 160)], float)
"""Millimetres."""
ELL = centred(CORNERS / 1e3)
SIDES = list(zip(CORNERS.tolist(), np.roll(CORNERS, -1, axis=0).tolist(), strict=True))
HIGH = 12.0


def svg(body: str, size: str = 'width="200mm" height="200mm" viewBox="0 0 200 200"') -> bytes:
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{body}</svg>'.encode()


def points(scale: float = 1.0) -> str:
    """Of SVG, in which y runs down."""
    return " ".join(f"{x * scale:g},{(180 - y) * scale:g}" for x, y in CORNERS)


def prism() -> list[list[tuple[float, float, float]]]:
    """Triangles of the L, 12 mm high."""
    faces = []
    for z in (0.0, HIGH):
        for a, b, c in ((0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)):
            faces.append([(*CORNERS[i], z) for i in (a, b, c)])
    for a, b in SIDES:
        faces += [[(*a, 0.0), (*b, 0.0), (*b, HIGH)], [(*a, 0.0), (*b, HIGH), (*a, HIGH)]]
    return faces


def stl() -> bytes:
    data = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(face), 0) for face in prism())
    return bytes(80) + struct.pack("<I", len(prism())) + data


def stl_in_words() -> bytes:
    rows = ["solid ell"]
    for face in prism():
        rows += [
            "facet normal 0 0 0",
            "outer loop",
            *(f"vertex {x} {y} {z}" for x, y, z in face),
            "endloop",
            "endfacet",
        ]
    return "\n".join([*rows, "endsolid ell"]).encode()


def obj() -> bytes:
    vertices = "".join(f"v {x} {y} {z}\n" for face in prism() for x, y, z in face)
    return (vertices + "".join(f"f {n} {n + 1} {n + 2}\n" for n in range(1, 3 * len(prism()), 3))).encode()


LINES = [f"0 LINE 8 0 10 {a[0]} 20 {a[1]} 11 {b[0]} 21 {b[1]}" for a, b in SIDES]
POLYLINE = "0 LWPOLYLINE 100 AcDbEntity 8 0 100 AcDbPolyline 90 6 70 1 " + " ".join(
    f"10 {x} 20 {y}" for x, y in CORNERS
)
RING = [*CORNERS.tolist(), CORNERS[0].tolist()]
FILES: dict[str, tuple[str, Callable[[], bytes], str | None]] = {
    "csv": ("a.csv", lambda: "\n".join(f"{x},{y}" for x, y in CORNERS).encode(), None),
    "csv with names": (
        "a.csv",
        lambda: ("x (mm) y (mm)\n" + "\n".join(f"{x} {y}" for x, y in CORNERS)).encode(),
        None,
    ),
    "csv of a spreadsheet": (
        "a.csv",
        lambda: (
            "\ufeffx;y\r\n" + "\r\n".join(f"{x:.1f};{y:.1f}".replace(".", ",") for x, y in CORNERS)
        ).encode(),
        None,
    ),
    "csv clockwise and closed": (
        "a.csv",
        lambda: "\n".join(f"{x},{y}" for x, y in RING[::-1]).encode(),
        None,
    ),
    "geojson": ("a.geojson", lambda: json.dumps({"type": "Polygon", "coordinates": [RING]}).encode(), None),
    "geojson in a collection": (
        "a.json",
        lambda: json.dumps(
            {
                "type": "FeatureCollection",
                "features": [
                    {"type": "Feature", "geometry": None},
                    {"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [[RING]]}},
                ],
            }
        ).encode(),
        None,
    ),
    "svg polygon": ("a.svg", lambda: svg(f'<polygon points="{points()}"/>'), "mm"),
    "svg path in a group": (
        "a.svg",
        lambda: svg(f'<g transform="translate(5 5) scale(2)"><path d="M {points(0.5)} Z"/></g>'),
        "mm",
    ),
    "svg in inches": (
        "a.svg",
        lambda: svg(
            f'<polygon points="{points()}"/>',
            f'width="{200 / 25.4}in" height="{200 / 25.4}in" viewBox="0 0 200 200"',
        ),
        "mm",
    ),
    "svg without a unit": (
        "a.svg",
        lambda: svg(f'<polygon points="{points()}"/>', 'width="200" height="200"'),
        None,
    ),
    "svg with a hidden frame": (
        "a.svg",
        lambda: svg(f'<rect width="190" height="190" display="none"/><polygon points="{points()}"/>'),
        "mm",
    ),
    "dxf of lines": ("a.dxf", lambda: dxf(*LINES), "mm"),
    "dxf of lines in any order": ("a.dxf", lambda: dxf(*LINES[::2], *LINES[1::2]), "mm"),
    "dxf of a polyline": ("a.dxf", lambda: dxf(POLYLINE), "mm"),
    "dxf without a unit": ("a.dxf", lambda: dxf(POLYLINE, unit=0), None),
    "stl": ("a.stl", stl, None),
    "stl in words": ("a.stl", stl_in_words, None),
    "obj": ("a.obj", obj, None),
}
"""By format: name, what makes the bytes, and the unit that they state."""


@pytest.mark.parametrize("name", FILES)
def test_the_same_outline_in_every_format(name, tmp_path):
    file, content, unit = FILES[name]
    (tmp_path / file).write_bytes(content())
    assert read(tmp_path / file, Scale()).unit == unit
    one = made(tmp_path / file, METRES["mm"])
    solid = file.endswith(("stl", "obj"))  # seen through a raster, 2000 pixels wide
    assert apart(polygon(one), ELL) < (1.5e-4 if solid else 2e-5)
    assert polygon(one).area == pytest.approx(ELL.area, rel=2e-3 if solid else 2e-4)
    assert len(polygon(one).exterior.coords) <= (30 if solid else 7)
    assert polygon(one).exterior.is_ccw


def test_a_solid_says_how_high_it_is(tmp_path):
    (tmp_path / "a.stl").write_bytes(stl())
    assert "along z, in which it measures 12" in read(tmp_path / "a.stl", Scale()).said


def test_curves_of_an_svg_are_followed(tmp_path):
    (tmp_path / "a.svg").write_bytes(svg('<circle cx="100" cy="100" r="70"/>'))
    disc = polygon(made(tmp_path / "a.svg"))
    assert disc.area == pytest.approx(np.pi * 0.07**2, rel=2e-3)


def test_curves_of_a_dxf_are_followed(tmp_path):
    (tmp_path / "a.dxf").write_bytes(dxf("0 CIRCLE 8 0 10 5 20 5 40 70"))
    assert polygon(made(tmp_path / "a.dxf")).area == pytest.approx(np.pi * 0.07**2, rel=2e-3)


def test_inches_of_a_dxf(tmp_path):
    (tmp_path / "a.dxf").write_bytes(dxf("0 CIRCLE 8 0 10 0 20 0 40 2", unit=1))
    assert read(tmp_path / "a.dxf", Scale()).unit == "in"


@pytest.mark.parametrize(
    ("file", "library"), [("a.svg", "svgelements"), ("a.dxf", "ezdxf"), ("a.stl", "trimesh")]
)
def test_without_the_extra_it_says_what_to_install(file, library, tmp_path, monkeypatch):
    content = {"a.svg": svg(""), "a.dxf": dxf(POLYLINE), "a.stl": stl()}[file]
    (tmp_path / file).write_bytes(content)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(
        UserError, match=rf"{library} is not installed; pip install 'deformpush\[cad\]' brings it$"
    ):
        read(tmp_path / file, Scale())
