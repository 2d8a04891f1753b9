"""The verb `view`: open recordings in the Rerun viewer, or write a picture of one without a display."""

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from deformpush.cli import output
from deformpush.errors import UserError

COMPARISON = "compare.rrd"


def main(argv: Sequence[str]) -> int:
    """Show recordings; exit code 0, or 1 when a view reports an error or the viewer ends with one.

    Raises:
        UserError: there is no recording, no such push, no display, or the picture exists already.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush view",
        description="Open recordings in the Rerun viewer, or write a picture of one without a display.",
    )
    parser.add_argument(
        "runs", nargs="+", metavar="RUN", help="run folders, or .rrd files such as compare.rrd"
    )
    parser.add_argument(
        "--screenshot", metavar="PNG", help="write this picture, 1600 x 900, and open no window"
    )
    parser.add_argument(
        "--push", type=int, metavar="K", help="show the state after push K (default: the last)"
    )
    output.add_overwrite(parser)
    given = parser.parse_args(argv)
    recordings = [recording(Path(run)) for run in given.runs]
    if given.screenshot is None:
        if given.push is not None:
            raise UserError("--push: only with --screenshot; the viewer's time panel goes to any push")
        return _window([part for one in recordings for part in one])
    if len(recordings) > 1:
        raise UserError("--screenshot: of one RUN; for several take compare, then view compare.rrd")
    return _picture(recordings[0], Path(given.screenshot), given.push, given.overwrite)


def recording(path: Path) -> list[Path]:
    """The recording that `path` means: a file, or that of a run, which may have parts, or a comparison.

    Raises:
        UserError: there is none.
    """
    from deformpush.record.folder import RECORDING, parts

    if path.is_file():
        return [path]
    if found := parts(path / RECORDING) or parts(path / COMPARISON):
        return found
    if not path.is_dir():
        raise UserError(f"{path}: no such run folder or recording")
    raise UserError(f"{path}: holds no {RECORDING}; record=off writes none, and compare makes one of a sweep")


def _window(recordings: Sequence[Path]) -> int:
    """Open the viewer and wait until it is closed."""
    if sys.platform.startswith("linux") and not {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ):
        raise UserError("view: no display here; --screenshot PNG writes a picture without one")
    from deformpush.viewer.live import program

    return subprocess.run([str(program()), *map(str, recordings)]).returncode and 1


def _picture(recording: Sequence[Path], picture: Path, push: int | None, overwrite: bool) -> int:
    from deformpush.record.files import replacing
    from deformpush.viewer.headless import last_push, screenshot

    if picture.suffix.lower() != ".png":
        raise UserError(f"--screenshot {picture}: must end in .png")
    output.make_room([picture], overwrite)
    last = max(map(last_push, recording))
    if push is not None and not 0 <= push <= last:
        raise UserError(f"--push {push}: the recording has the states after push 0 to {last}")
    with replacing(picture) as made:
        complaints = screenshot(recording, made, last if push is None else push)
    for line in complaints:
        print(f"a view reports an error: {line}", file=sys.stderr)
    print(f"written:   {picture}")
    return 1 if complaints else 0
