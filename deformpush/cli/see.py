"""The verb `see`: what is seen in a picture, and by what; a camera calibrated from a printed sheet."""

import argparse
from collections.abc import Sequence

from deformpush.cli import output
from deformpush.errors import UserError


def main(argv: Sequence[str]) -> int:
    """See, print the sheet, or calibrate; exit code 0.

    Raises:
        UserError: a picture or a camera cannot be read or does not tell what is asked, or a file is there.
    """
    given = _parser().parse_args(argv)
    asked = [name for name in ("picture", "print_sheet", "calibrate") if getattr(given, name) is not None]
    if len(asked) != 1:
        raise UserError("see: needs one of PICTURE, --print-sheet FILE and --calibrate PICTURE ...")
    if given.name is not None and not given.name.isidentifier():
        raise UserError(f"--name {given.name}: must be a name of letters, digits and _")
    if given.print_sheet is not None:
        from deformpush.cli.see_camera import print_sheet

        return print_sheet(given)
    if given.calibrate is not None:
        from deformpush.cli.see_camera import calibrate

        return calibrate(given)
    from deformpush.cli.see_picture import see

    return see(given)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m deformpush see",
        description="Show what is seen in a picture, and write the setting by which a run sees it; or make a "
        "sheet to calibrate a camera with, and calibrate it.",
        epilog="examples: see fillet.jpg --empty table.jpg --out my_conf;  see --print-sheet sheet.pdf;  "
        "see --calibrate table.jpg tilted-*.jpg --square 25 --out my_conf",
    )
    parser.add_argument(
        "picture", nargs="?", metavar="PICTURE", help="PNG or JPEG of the object on the table"
    )
    parser.add_argument("--out", metavar="FOLDER", help="your folder of settings, for --config-dir")
    parser.add_argument("--name", help="of the option that is written (default: as the picture; calibrated)")
    output.add_overwrite(parser)
    seen = parser.add_argument_group("of a picture")
    seen.add_argument("--empty", metavar="PICTURE", help="the same table, empty; without: it has one colour")
    seen.add_argument(
        "--by", choices=("hsv", "background"), help="default: hsv if colours tell, else background"
    )
    seen.add_argument(
        "--on", nargs=2, type=float, metavar=("X", "Y"), help="a pixel on the object: take its colours"
    )
    scale = seen.add_mutually_exclusive_group()
    scale.add_argument(
        "--camera", metavar="YAML", help="the camera's file, such as my_conf/camera/calibrated.yaml"
    )
    scale.add_argument(
        "--mm-per-px", type=float, metavar="MM", help="millimetres a pixel; without: in pixels"
    )
    camera = parser.add_argument_group("of a camera")
    camera.add_argument("--print-sheet", metavar="FILE", help="write the sheet, A4, as .png or .pdf")
    camera.add_argument(
        "--calibrate",
        nargs="+",
        metavar="PICTURE",
        help="first one with the sheet on the table, then tilted ones",
    )
    camera.add_argument("--square", type=float, metavar="MM", help="side of a printed square, as measured")
    camera.add_argument(
        "--at",
        nargs=3,
        type=float,
        metavar=("X", "Y", "DEG"),
        help="the sheet's middle on the table (m), and its turn (default: middle of camera=bottom, 0)",
    )
    camera.add_argument(
        "--side",
        choices=("below", "above"),
        default="below",
        help="of the table the camera is on (default: below)",
    )
    return parser
