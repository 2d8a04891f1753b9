"""Which reader a file is for, by the end of its name."""

from pathlib import Path

from deformpush.errors import UserError
from deformpush.outlines.drawing import Drawing
from deformpush.outlines.picture import Scale

KINDS = {
    ".png": "picture",
    ".jpg": "picture",
    ".jpeg": "picture",
    ".svg": "svg",
    ".dxf": "dxf",
    ".stl": "solid",
    ".obj": "solid",
    ".csv": "csv",
    ".geojson": "geojson",
    ".json": "geojson",
}
"""By the end of a file's name."""


def kind_of(path: Path) -> str:
    """What sort of file it is.

    Raises:
        UserError: none that can be read.
    """
    kind = KINDS.get(path.suffix.lower())
    if kind is None:
        raise UserError(f"{path}: must end in {', '.join(KINDS)}")
    return kind


def read(path: Path, scale: Scale) -> Drawing:
    """The closed lines of a file.

    Raises:
        UserError: in one line, what is wrong with it.
    """
    kind = kind_of(path)
    if kind == "picture":
        from deformpush.outlines import picture

        return picture.read(path, scale)
    if kind == "svg":
        from deformpush.outlines import svg

        return svg.read(path)
    if kind == "dxf":
        from deformpush.outlines import dxf

        return dxf.read(path)
    if kind == "solid":
        from deformpush.outlines import solid

        return solid.read(path)
    from deformpush.outlines import point_list

    return point_list.read_csv(path) if kind == "csv" else point_list.read_geojson(path)
