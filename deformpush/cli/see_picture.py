"""`see PICTURE`: what is in it, how it was told from the table, and a picture of that."""

import argparse
import re
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from deformpush.cli import output
from deformpush.cli.see_camera import write_option
from deformpush.errors import UserError

if TYPE_CHECKING:
    from deformpush.cell.background import Background
    from deformpush.cell.camera import Camera
    from deformpush.cell.observation import Observation
    from deformpush.cell.perception import Perception
    from deformpush.cell.sight import Sight

Array = np.ndarray

SMALLEST, LARGEST = 16, 1280
"""Pictures with a shorter side are refused; those with a longer side are made smaller first (px)."""
LEAST = 0.002
"""An object is at least this share of the picture."""
AGREE = 0.95
"""Colours that agree less with the difference from the table do not tell the object."""


def see(given: argparse.Namespace) -> int:
    """Look, tell, draw and write; exit code 0."""
    from deformpush.cell.segmentation import PerceptionError
    from deformpush.config import build as config
    from deformpush.config.compose import compose
    from deformpush.record.files import write_whole

    source = Path(given.picture)
    name = given.name or re.sub(r"\W+", "_", source.stem).strip("_") or "seen"
    drawn = source.with_name(f"{source.stem}_seen.png")
    folder = None if given.out is None else Path(given.out) / "contour"
    option = None if folder is None else folder / f"{name}.yaml"
    kept = None if folder is None else folder / f"{name}_empty.png"
    written = (drawn, option, kept if given.empty else None)
    output.make_room([path for path in written if path is not None], given.overwrite)
    raw = read(given.picture)
    picture, camera, unit = _as_seen(given.picture, raw, given)
    place = None if given.on is None else _place(given.on, raw, picture, camera)
    eye = config.build(compose(["contour=background"]).contour)
    least = LEAST * picture.shape[0] * picture.shape[1] / camera.scale**2
    eye = replace(eye, min_area=min(eye.min_area, least) if unit == "mm" else least)
    with tempfile.TemporaryDirectory() as scratch:
        table = replace(eye.segmentation, empty=_empty(given, picture, scratch))
        try:
            found, by, doubt = _sight(picture, camera, eye, table, given, place)
        except PerceptionError as problem:
            raise UserError(f"{given.picture}: {problem}") from problem
        told = _told(found, doubt, camera, unit, given)
        for key, value in told:
            print(f"{key + ':':10} {value}")
        with output.writing(drawn):
            write_whole(drawn, _figure(picture, camera, found.seen, told))
        print(f"written:   {drawn}, what is seen, to check by eye")
        if option is not None and kept is not None:
            settings = _settings(found, by, kept if given.empty else None, camera, unit)
            if by == "background" and given.empty:
                with output.writing(kept):
                    write_whole(kept, Path(str(table.empty)).read_bytes())
            write_option(option, f"# Found by `see`: {dict(told)['by']}.\n", settings, f"contour={name}")
    return 0


def _sight(
    picture: Array,
    camera: "Camera",
    eye: "Perception",
    table: "Background",
    given: argparse.Namespace,
    place: "tuple[float, float] | None",
) -> "tuple[Sight, str, str]":
    """What is seen, the option of `contour` that sees it, and why it is not the other."""
    from deformpush.cell.sight import by_colour, by_difference, by_place

    if place is not None:
        return by_place(picture, camera, eye, place), "hsv", ""
    sight = by_difference(picture, camera, eye, table)
    if given.by == "background":
        return sight, "background", ""
    coloured = by_colour(picture, camera, sight)
    if coloured.agreement >= AGREE or (given.by == "hsv" and coloured.agreement):
        return coloured, "hsv", ""
    if given.by == "hsv":
        raise UserError(f"{given.picture}: no ranges of colour tell the object; --by background does")
    agree = f"agree with it to {coloured.agreement:.0%} only" if coloured.agreement else "do not tell it"
    return sight, "background", f" (ranges of colour {agree})"


def read(name: str) -> Array:
    """The picture in a file.

    Raises:
        UserError: there is none, or none that is read.
    """
    from deformpush.cell import picture_file

    try:
        return picture_file.read(name)
    except ValueError as error:
        raise UserError(f"{name}: {error}") from error


def _as_seen(name: str, picture: Array, given: argparse.Namespace) -> "tuple[Array, Camera, str]":
    """A picture as perception has it, its camera, and in what one speaks of lengths."""
    from deformpush.cell import picture_file
    from deformpush.cell.camera import Camera
    from deformpush.cell.segmentation import PerceptionError

    if given.camera is not None:
        camera = read_camera(Path(given.camera))
        try:
            seen = camera.rectified(picture)
        except PerceptionError as problem:
            raise UserError(f"{name}: {problem}") from problem
        if seen.shape != (camera.pixels, camera.pixels, 3):
            raise UserError(
                f"{name}: has {picture.shape[1]} x {picture.shape[0]} pixels, the camera's pictures "
                f"{camera.pixels} x {camera.pixels}"
            )
        return seen, camera, "mm"
    mm = 1.0 if given.mm_per_px is None else given.mm_per_px
    if not 1e-3 <= mm <= 100:
        raise UserError(f"--mm-per-px {mm:g}: must be 0.001 to 100")
    across = picture.shape[1]
    picture = picture_file.shrunk(picture, LARGEST)
    high, wide = picture.shape[:2]
    if min(high, wide) < SMALLEST:
        raise UserError(f"{name}: is {wide} x {high} pixels (the longer side {LARGEST} at most), too small")
    metres = mm * across / wide / 1e3
    # The origin is the lower left corner: x to the right, y up.
    camera = Camera((wide * metres / 2, (high - wide / 2) * metres), wide * metres, 3.0, wide)
    return picture, camera, "px" if given.mm_per_px is None else "mm"


def _place(on: list[float], raw: Array, picture: Array, camera: "Camera") -> tuple[float, float]:
    """A pixel of the file as one of the picture that perception has.

    Raises:
        UserError: it is outside of that.
    """
    from deformpush.cell.calibrated import CalibratedCamera

    if isinstance(camera, CalibratedCamera):
        column, row = camera.to_px(camera.from_raw(np.array([on])))[0]
    else:
        column, row = (np.array(on) + 0.5) * picture.shape[1] / raw.shape[1] - 0.5
    if not (0 <= column <= picture.shape[1] - 1 and 0 <= row <= picture.shape[0] - 1):
        raise UserError(f"--on {on[0]:g} {on[1]:g}: is outside of the picture")
    return float(column), float(row)


def read_camera(path: Path) -> "Camera":
    """The camera that a file of settings describes.

    Raises:
        UserError: there is none.
    """
    from deformpush.cell.camera import Camera
    from deformpush.config.build import component
    from deformpush.record.saved_config import SavedConfigError, read_config

    try:
        settings = read_config(path)
    except OSError as error:
        raise UserError(f"--camera {path}: {error.strerror}") from error
    except SavedConfigError as error:
        raise UserError(f"--camera {path}: {error}") from error
    try:
        camera: Camera = component(settings, "camera", kind=Camera)()
    except UserError as error:
        raise UserError(f"--camera {path}: {error}") from error
    return camera


def _empty(given: argparse.Namespace, like: Array, scratch: str) -> str | None:
    """A file with the empty table as perception has its pictures.

    Raises:
        UserError: it is no picture, or not as large as that of the object.
    """
    from deformpush.cell import picture_file

    if given.empty is None:
        return None
    picture, _, _ = _as_seen(given.empty, read(given.empty), given)
    if picture.shape != like.shape:
        raise UserError(f"--empty {given.empty}: must be as large as {given.picture}")
    path = Path(scratch) / "empty.png"
    path.write_bytes(picture_file.png(picture))
    return str(path)


def _told(
    found: "Sight", doubt: str, camera: "Camera", unit: str, given: argparse.Namespace
) -> list[tuple[str, str]]:
    """What is told of a sight."""
    from deformpush.cell.segmentation import HsvRanges

    seen, by = found.seen, found.perception.segmentation
    along, across = (1e3 * side for side in found.extent)
    x, y = seen.c * 1e3
    frame = "table frame" if given.camera else "from the lower left corner, y up"
    size = f"{found.area * 1e4:.2f} cm2" if unit == "mm" else f"{found.area * 1e6:.0f} px"
    if isinstance(by, HsvRanges):
        told = [f"hue {a[0]}-{b[0]}, saturation {a[1]}-{b[1]}, value {a[2]}-{b[2]}" for a, b in by.ranges]
        how = f"{len(told)} range{'s' * (len(told) > 1)} of colour: {'; '.join(told)}"
    else:
        how = f"difference from {'a picture of the empty table' if given.empty else 'the colour of the rim'}"
    turned = (
        "nearly round, the angle means little" if seen.compact else f"{np.degrees(seen.theta):.1f} degrees"
    )
    return [
        ("by", how + doubt),
        ("area", f"{size}, {along:.1f} {unit} long and {across:.1f} {unit} wide"),
        ("pose", f"({x:.1f}, {y:.1f}) {unit}, {turned} ({frame})"),
        ("contrast", f"{found.contrast:.0f} levels of 255 to the table, which varies by {found.noise:.0f}"),
    ]


def _figure(picture: Array, camera: "Camera", seen: "Observation", told: list[tuple[str, str]]) -> bytes:
    from deformpush.study import seen_figure

    contour, middle = camera.to_px(seen.contour), camera.to_px(seen.c)
    theta = None if seen.compact else seen.theta
    return seen_figure.draw(picture, contour, middle, theta, told)


def _settings(found: "Sight", by: str, empty: Path | None, camera: "Camera", unit: str) -> dict[str, Any]:
    """The option by which a run sees the same."""
    from deformpush.cell.segmentation import HsvRanges

    telling: dict[str, Any] = {"empty": str(empty.resolve()) if empty else None}
    if isinstance(ranges := found.perception.segmentation, HsvRanges):
        telling = {"ranges": ranges.ranges}
    settings: dict[str, Any] = {"defaults": [by, "_self_"], "segmentation": telling}
    quarter = float(f"{found.area / 4:.2g}")
    if unit == "mm" and quarter < found.perception.min_area:
        settings["min_area"] = quarter
    return settings
