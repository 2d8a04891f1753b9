"""Where a verb writes: never over a file that is there, unless it is told to."""

import argparse
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from deformpush.errors import TroubleError, UserError


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    """Add the flag --overwrite."""
    parser.add_argument("--overwrite", action="store_true", help="replace files that are there already")


def make_room(paths: Sequence[Path], overwrite: bool) -> None:
    """Make the folders of `paths`; none of the files may be there, unless `overwrite`.

    Raises:
        UserError: a file exists, or its folder cannot be made or written to.
    """
    if taken := [path for path in paths if path.exists() and not overwrite]:
        names = ", ".join(path.name for path in taken)
        raise UserError(
            f"{taken[0].parent}: {names} exists already; --overwrite replaces it, --out writes elsewhere"
        )
    for folder in {path.parent for path in paths}:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{folder}: cannot be made ({error.strerror})") from error
        if not os.access(folder, os.W_OK):
            raise UserError(f"{folder}: cannot write there; --out writes elsewhere")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Say in one line that a file could not be written; what was there before is still there.

    Raises:
        TroubleError: no room, or no permission.
    """
    try:
        yield
    except OSError as error:
        raise TroubleError(f"{path}: cannot be written ({error.strerror or error})") from error
