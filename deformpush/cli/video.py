"""The verb `video`: an MP4 of a run."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from deformpush.cli import output
from deformpush.errors import UserError

VIDEO = "video.mp4"
SECONDS = 0.5


def main(argv: Sequence[str]) -> int:
    """Make the film of a run; exit code 0.

    Raises:
        UserError: the folder holds no finished run, or the film exists already.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush video",
        description="Make an MP4 of a run: its bottom view, and the errors growing with it.",
    )
    parser.add_argument("run", metavar="RUN", help="folder of a run")
    parser.add_argument("--out", metavar="MP4", help=f"where to write (default: {VIDEO} in that folder)")
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, metavar="S", help=f"for each push (default: {SECONDS})"
    )
    output.add_overwrite(parser)
    given = parser.parse_args(argv)
    folder = Path(given.run)
    path = Path(given.out) if given.out else folder / VIDEO
    if path.suffix.lower() != ".mp4":
        raise UserError(f"--out {path}: must end in .mp4")
    if not 0.1 <= given.seconds <= 10:
        raise UserError(f"--seconds {given.seconds:g}: must be 0.1 to 10")

    from deformpush.record.files import replacing
    from deformpush.record.finished import NotFinishedError, read
    from deformpush.record.folder import RunFolder
    from deformpush.study import run_data

    try:
        finished = read(RunFolder(folder), folder.name)
        run = run_data.read(RunFolder(folder))
    except NotFinishedError as error:
        raise UserError(f"{folder}: {error}") from error
    except (OSError, ValueError) as error:
        raise UserError(str(error)) from error
    output.make_room([path], given.overwrite)

    from deformpush.study import film

    with output.writing(path), replacing(path) as made:
        seconds = film.write(made, finished, run, given.seconds)
    print(f"written:   {path} ({seconds:.0f} s, {path.stat().st_size / 1e6:.1f} MB)")
    return 0
