"""The verb `resume`: continue a run that was killed, stopped, or failed."""

import argparse
from collections.abc import Sequence

from deformpush.cli import own_classes


def main(argv: Sequence[str]) -> int:
    """Continue a run; the exit code is that of the run.

    Raises:
        UserError: there is no run to continue, or another process works on it.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush resume",
        description="Continue a run where its pushes.csv ends: from the last state that its world saved, "
        "or where there is none by making the pushes again. It goes on to the row that it would have come to "
        "without the interruption.",
    )
    parser.add_argument("run", help="run folder")
    own_classes.add(parser)
    given = parser.parse_args(argv)
    own_classes.use(given)
    from deformpush.cli.exit_code import exit_code
    from deformpush.experiment.run import resume

    return exit_code(resume(given.run))
