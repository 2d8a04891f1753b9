"""The verb `object`: from a picture, a drawing or a list of points to an object that can be pushed."""

import argparse
import math
import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deformpush.cli import output
from deformpush.config.groups import conf_dir, option_groups, suggest
from deformpush.errors import UserError

if TYPE_CHECKING:
    from deformpush.outlines.drawing import Drawing
    from deformpush.outlines.sheet import Preset

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
WORDS = {"null", "none", "true", "false", "yes", "no", "on", "off", "nan", "inf"}
"""A value that is called so on the command line means something else."""
OF_PICTURES = {
    "mm_per_px": "--mm-per-px X",
    "marker": "--marker MM",
    "charuco_square": "--charuco-square MM",
    "length": "--length MM",
}
"""Flags that tell the scale of a picture."""
UNITS = ("mm", "cm", "m", "in")
MASK_MARGIN, TABLE_MARGIN = 1.25, 0.45
"""Room that an object needs on the raster of masks (of its size), and in the camera's picture (m)."""


def main(argv: Sequence[str]) -> int:
    """Write the YAML of an object and a picture of it; exit code 0.

    Raises:
        UserError: the file cannot be read, its scale is not told, no good mesh comes of it, or what would be
            written is there already.
    """
    if not argv:
        options = ", ".join(option_groups()["object"])
        raise UserError(
            f"object: needs an option, as in object=rect; options of object: {options}; "
            "or a file: object from FILE --out my_conf"
        )
    given = _parser().parse_args(argv)
    words = [word for word in argv if word != "--overwrite"]
    return _from_file(given, f"python -m deformpush object {shlex.join(words)}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m deformpush object",
        description="Make an object from a photo, a mask, a drawing, a solid or a list of points.",
    )
    verb = parser.add_subparsers(dest="action", required=True, metavar="from").add_parser(
        "from",
        help="a file",
        description="Make an object from FILE: its YAML for --config-dir, and a picture to check it by.",
    )
    verb.add_argument("file", metavar="FILE", help="PNG, JPEG, SVG, DXF, STL, OBJ, CSV or GeoJSON")
    verb.add_argument(
        "--out", metavar="DIR", required=True, help="your folder of settings: DIR/object/NAME.yaml"
    )
    verb.add_argument("--name", metavar="NAME", help="what it is called (default: as the file)")
    verb.add_argument("--like", metavar="OBJECT", default="rect", help="object whose material it has (rect)")
    verb.add_argument("--thickness", metavar="MM", type=_positive, help="default: that of --like")
    verb.add_argument(
        "--cell", metavar="MM", type=_positive, help="size of the mesh's cells (default: chosen)"
    )
    scale = verb.add_argument_group("scale, one of them").add_mutually_exclusive_group()
    scale.add_argument("--mm-per-px", metavar="X", type=_positive, help="of a picture: millimetres a pixel")
    scale.add_argument(
        "--marker", metavar="MM", type=_positive, help="side of an ArUco marker in the picture"
    )
    scale.add_argument(
        "--charuco-square", metavar="MM", type=_positive, help="square of a ChArUco sheet in the picture"
    )
    scale.add_argument("--length", metavar="MM", type=_positive, help="longer side of the object")
    scale.add_argument("--unit", choices=UNITS, help="of a drawing, solid or list that states none")
    output.add_overwrite(verb)
    return parser


def _from_file(given: argparse.Namespace, command: str) -> int:
    from deformpush.outlines.make import Wanted, make
    from deformpush.outlines.overlay import draw
    from deformpush.outlines.picture import Scale
    from deformpush.outlines.read import kind_of, read
    from deformpush.record.files import replacing, write_whole

    file, folder = Path(given.file), Path(given.out) / "object"
    name = _name(given.name, file, folder)
    _ask_for_a_scale(given, file, kind_of(file))
    preset, sheet, node = _preset(given.like)
    paths = [folder / f"{name}.yaml", folder / f"{name}.png"]
    drawing = read(file, Scale(given.mm_per_px, given.marker, given.charuco_square))
    print(f"read:      {file.name}, {drawing.said}")
    metre = _metre(given, drawing, file)
    wanted = Wanted(
        name,
        sheet.thickness if given.thickness is None else given.thickness / 1e3,
        None if given.cell is None else given.cell / 1e3,
        metre,
        None if given.length is None else given.length / 1e3,
    )
    head = [
        f"{name}: the outline of {_plain(file.name)}, the material of {given.like}. Made by",
        _plain(command),
    ]
    try:
        made = make(drawing, wanted, preset, head, sheet.cell)
    except ValueError as error:
        raise UserError(f"{file}: {error}") from error
    _check(node, made.text)
    for line in made.lines:
        print(line)
    output.make_room(paths, given.overwrite)
    with output.writing(paths[1]), replacing(paths[1]) as temporary:
        draw(made.overlay, temporary)
    with output.writing(paths[0]):
        write_whole(paths[0], made.text.encode())
    print(f"written:   {paths[0]}")
    print(f"look at:   {paths[1]}, whether the outline is that of the object")
    print(f"push it:   {_next(given.out, name, made.size)}")
    return 0


def _name(name: str | None, file: Path, folder: Path) -> str:
    """The object's name.

    Raises:
        UserError: it is none, or that of an object that deformpush has.
    """
    chosen = name if name is not None else re.sub(r"[^A-Za-z0-9_]+", "_", file.stem).strip("_")
    if not NAME.fullmatch(chosen) or chosen.lower() in WORDS:
        raise UserError(
            f"--name {chosen!r}: must begin with a letter, then letters, digits and _, such as my_fish"
        )
    if _shipped(chosen, folder):
        raise UserError(f"--name {chosen}: deformpush has an object of that name; give yours another")
    return chosen


def _shipped(name: str, folder: Path) -> bool:
    """Whether deformpush has an object of that name, and not in this folder: Hydra would take that one."""
    shipped = conf_dir() / "object"
    return (shipped / f"{name}.yaml").exists() and folder.resolve() != shipped.resolve()


def _ask_for_a_scale(given: argparse.Namespace, file: Path, kind: str) -> None:
    """Refuse a flag that does not suit the file, and a picture without one.

    Raises:
        UserError: says which flags there are.
    """
    told = [flag for key, flag in OF_PICTURES.items() if getattr(given, key) is not None]
    if kind == "picture":
        if not told:
            flags = ", ".join(OF_PICTURES.values())
            raise UserError(f"{file}: how large is it? One of {flags} must say so")
    elif told and given.length is None:
        raise UserError(
            f"{told[0].split()[0]}: is for pictures; for {file.name} there are --unit and --length"
        )


def _metre(given: argparse.Namespace, drawing: "Drawing", file: Path) -> float | None:
    """Length of the file's unit (m); None where the object's length is given instead.

    Raises:
        UserError: nobody says it.
    """
    from deformpush.outlines.drawing import METRES

    if given.length is not None:
        return None
    if drawing.mm_per_px is not None:
        print(f"scale:     {drawing.mm_per_px:.4g} mm a pixel")
        return drawing.mm_per_px / 1e3
    if given.unit is not None:
        if drawing.unit not in (None, given.unit):
            print(f"unit:      {given.unit}, as --unit says; the file itself says {drawing.unit}")
        elif drawing.unit is not None:
            print(f"unit:      {given.unit}, as the file itself says")
        return METRES[given.unit]
    if drawing.unit is not None:
        print(f"unit:      {drawing.unit}, as the file says")
        return METRES[drawing.unit]
    units = "|".join(UNITS)
    raise UserError(f"{file}: states no unit; --unit {units} or --length MM must say how large it is")


def _preset(like: str) -> tuple["Preset", Any, dict[str, Any]]:
    """The object whose material it gets: what the YAML needs of it, itself, and its settings.

    Raises:
        UserError: there is none of that name.
    """
    from deformpush.config.build import build, plain
    from deformpush.config.compose import compose
    from deformpush.outlines.sheet import Preset

    known = option_groups()["object"]
    if like not in known:
        raise UserError(f"--like {like}: no such object{suggest(like, known)}; objects: {', '.join(known)}")
    node = plain(compose([f"object={like}"]))["object"]
    sheet = build(node, "object")
    preset = Preset(
        like,
        sheet.slab.outline.area,
        sheet.d,
        sheet.dt,
        sheet.thickness,
        sheet.material.mass,
        sheet.goal_mask is not None,
        sheet.slab.mesh,
    )
    return preset, sheet, node


def _check(node: dict[str, Any], text: str) -> None:
    """See that what is about to be written would be taken: the preset's settings, and these over them."""
    import yaml

    from deformpush.config.build import build

    own = yaml.safe_load(text)
    del own["defaults"]
    material = {**node["material"], **own.pop("material", {})}
    build({**node, **own, "material": material}, "object")


def _next(out: str, name: str, size: float) -> str:
    """The command that pushes it: with room for a large object on raster and picture."""
    words = ["--config-dir", out, f"object={name}", "world=mujoco", "robot=tool", "optimizer=abo_motion"]
    if size * MASK_MARGIN > 0.36:
        words.append(f"contour.mask.size={math.ceil(size * MASK_MARGIN * 50) / 50:g}")
    if size + TABLE_MARGIN > 0.7:
        words.append(f"camera.field={math.ceil((size + TABLE_MARGIN) * 10) / 10:g}")
    return f"python -m deformpush {shlex.join(words)}"


def _plain(text: str) -> str:
    """A text as one line of a comment."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"{text}: must be a number above 0")
    return value
