"""`see --print-sheet` and `see --calibrate`."""

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Literal

from deformpush.cli import output
from deformpush.errors import UserError

NAME = "calibrated"
DOUBTFUL_MM = 2.0
"""Beyond this error at the rim, more pictures are worth taking."""
MOST = 200
"""Pictures that are read."""


def print_sheet(given: argparse.Namespace) -> int:
    """Write the sheet; exit code 0."""
    from deformpush.cell import calibration_sheet as sheet
    from deformpush.record.files import write_whole

    path = Path(given.print_sheet)
    kinds = {".png": sheet.png, ".pdf": sheet.pdf}
    if path.suffix.lower() not in kinds:
        raise UserError(f"--print-sheet {path}: must end in .png or .pdf")
    output.make_room([path], given.overwrite)
    with output.writing(path):
        write_whole(path, kinds[path.suffix.lower()](sheet.page()))
    print(
        f"written:   {path}, A4, squares of {sheet.SQUARE_MM:g} mm; print it without scaling and measure it: "
        f"{sheet.ROWS} squares are {sheet.ROWS * sheet.SQUARE_MM:g} mm"
    )
    return 0


def calibrate(given: argparse.Namespace) -> int:
    """Calibrate, tell how well, and write the camera; exit code 0."""
    from deformpush.cell.calibration import CalibrationError
    from deformpush.cell.calibration import calibrate as calibrated
    from deformpush.cli.see_picture import read
    from deformpush.config.compose import compose

    if given.square is None:
        raise UserError("--square MM: missing; measure the printed sheet, a square is a tenth of its height")
    if not 1 <= given.square <= 1000:
        raise UserError(f"--square {given.square:g}: must be 1 to 1000 mm")
    if given.at is not None and not all(abs(value) <= 720 for value in given.at):
        raise UserError(f"--at {' '.join(map(str, given.at))}: must be metres, metres and degrees")
    if len(given.calibrate) > MOST:
        raise UserError(f"--calibrate: {len(given.calibrate)} pictures, at most {MOST} are read")
    path = None if given.out is None else Path(given.out) / "camera" / f"{given.name or NAME}.yaml"
    if path is not None:
        output.make_room([path], given.overwrite)
    usual = compose([]).camera
    x, y, degrees = given.at or (*usual.centre, 0.0)
    side: Literal["above", "below"] = given.side
    pictures = [read(name) for name in given.calibrate]
    try:
        found = calibrated(pictures, given.square / 1e3, (x, y), degrees, side, float(usual.rate))
    except CalibrationError as error:
        raise UserError(f"--calibrate: {error}") from error
    camera = found.camera
    centre = ", ".join(f"{value:.3f}" for value in camera.centre)
    sheet, rim = f"{found.table_mm:.2f} mm (rms), {found.worst_mm:.2f} mm (largest)", f"{found.rim_mm:.2f} mm"
    print(f"pictures:  {found.used} of {len(pictures)} used, {camera.size[0]} x {camera.size[1]} px")
    print(f"lens:      focal length {camera.focal[0]:.0f} px; corners within {found.px:.2f} px (rms)")
    print(f"place:     {camera.distance:.3f} m {side} the table")
    print(f"sees:      {camera.field:.3f} m about ({centre}) m, {1e3 / camera.scale:.2f} mm a pixel")
    print(f"error:     {sheet} where the sheet lies on the table, {rim} expected at the picture's rim")
    if found.rim_mm > DOUBTFUL_MM:
        print("           take more pictures, with the sheet tilted and near the corners of the picture")
    if path is not None:
        told = (
            f"# A camera {side} the table, by `see --calibrate`. Error: {found.table_mm:.2f} mm where the\n"
            f"# sheet lay, {rim} expected at the rim. centre, field and pixels choose what is cut out.\n"
        )
        target = f"{type(camera).__module__}.{type(camera).__name__}"
        write_option(path, told, {"_target_": target} | asdict(camera), f"camera={path.stem}")
    return 0


def write_option(path: Path, comment: str, settings: dict[str, object], option: str) -> None:
    """Write the file of an option, and say how it is chosen."""
    from deformpush.record.files import write_whole

    with output.writing(path):
        write_whole(path, (comment + _yaml(settings)).encode())
    print(f"written:   {path}; --config-dir {path.parent.parent} {option} uses it")


def _yaml(settings: dict[str, object]) -> str:
    """Settings as YAML, lists and groups in one line each."""
    return "".join(f"{key}: {json.dumps(value)}\n" for key, value in settings.items())
