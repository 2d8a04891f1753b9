"""docs/security.md names a test for every promise, and the limits it tells are those of the readers."""

import re

import pytest

from deformpush.cell import picture_file
from deformpush.experiment.sweep.manifest import SWEEP_BYTES
from deformpush.outlines import clean, drawing, dxf, picture, point_list, solid, svg
from deformpush.record import blocks, files, npz, provenance, saved_config
from tests.pages import ROOT, page, rows, sections

PAGE = page("docs/security.md")
SECTIONS = sections(PAGE)


@pytest.mark.parametrize(
    "section", ["What a stranger's folder cannot do", "What each reader accepts", "What `object from` reads"]
)
def test_every_promise_names_tests_that_exist(section):
    for row in rows(SECTIONS[section]):
        named = re.findall(r"`(tests/[\w/]+\.py)`", row["test"])
        assert named, row
        assert [name for name in named if not (ROOT / name).is_file()] == []


def size(count: int) -> str:
    return f"{count // 10**9} GB" if count >= 10**9 else f"{count // 10**6} MB"


def test_the_limits_are_those_of_the_readers():
    readers = rows(SECTIONS["What each reader accepts"])
    told = {row["file"]: (row["at most"], row["what else is checked"]) for row in readers}
    most = {name.strip("` "): limit for names, (limit, _) in told.items() for name in names.split(",")}
    assert most == {
        "config.yaml": size(files.JSON_BYTES),
        "summary.json": size(files.JSON_BYTES),
        "provenance.json": size(provenance.PROVENANCE_BYTES),
        "sweep.json": size(SWEEP_BYTES),
        "pushes.csv": size(files.TABLE_BYTES),
        "forecasts.csv": size(files.TABLE_BYTES),
        "regret.csv": size(files.TABLE_BYTES),
        "regret_trials.csv": size(files.TABLE_BYTES),
        "contours.npz": size(npz.NPZ_BYTES),
        "views.npz": size(npz.NPZ_BYTES),
        "checkpoint.npz": size(npz.NPZ_BYTES),
        "states.bin": size(blocks.FILE_BYTES),
        "world_states.bin": size(blocks.FILE_BYTES),
        "pictures of the camera": f"{picture_file.MOST_PX:,} pixels a side",
        "pictures for `see` and of an empty table": size(picture_file.MOST_BYTES),
        "figures/run.png": size(files.FIGURE_BYTES),
    }
    assert told["`config.yaml`"][1] == f"{saved_config.MOST:,} values, {saved_config.DEEPEST} levels"
    assert f"{npz.MEMBERS} arrays" in told["`contours.npz`, `views.npz`, `checkpoint.npz`"][1]
    assert size(blocks.BLOCK_BYTES) in told["`states.bin`"][1]


def test_the_limits_of_drawings_are_those_of_their_readers():
    section = "What `object from` reads"
    told = {row["file"]: (row["at most"], row["what else is checked"]) for row in rows(SECTIONS[section])}
    readers = {"PNG, JPEG": picture, "SVG": svg, "DXF": dxf, "STL, OBJ": solid, "CSV, GeoJSON": point_list}
    assert {file: limit for file, (limit, _) in told.items()} == {
        file: size(reader.BYTES) for file, reader in readers.items()
    }
    assert f"{picture.MOST_PX:,} pixels a side" in told["PNG, JPEG"][1]
    elements = f"{svg.MOST_ELEMENTS:,} elements, {svg.MOST_DEPTH} levels, {svg.MOST_SEGMENTS:,} segments"
    assert elements in told["SVG"][1]
    assert f"{dxf.MOST_ENTITIES:,} entities" in told["DXF"][1]
    assert f"{solid.MOST_FACES:,} triangles" in told["STL, OBJ"][1]
    text = PAGE.partition(section)[2]
    assert f"{drawing.MOST_LINES:,} lines of {drawing.MOST_POINTS:,} points" in text
    assert f"{clean.SCRIBBLE} times the drawing" in text
