"""The verb `regret`: what the best push would have gained in each state of a run, and what was foreseen."""

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from deformpush.cli import output, own_classes


def main(argv: Sequence[str]) -> int:
    """Measure regret and calibration of a run; exit code 0 when that is done.

    Raises:
        UserError: there is no such run, its world cannot branch, or the files to write are of something else.
        TroubleError: the run does not repeat itself here, or the files cannot be written.
    """
    from deformpush.record.regret_table import PUSHES, REGRET, TRIALS, read, read_trials

    parser = argparse.ArgumentParser(
        prog="python -m deformpush regret",
        description="Make a run again and try other pushes from each of its states: what the best of them "
        "would have gained (regret), and whether the model's forecasts for all of them came true "
        "(calibration). Writes regret.csv, regret_trials.csv and regret.png into the run's folder; stopped, "
        "the same command goes on.",
        epilog="example: python -m deformpush regret runs/mine --pushes 48",
    )
    parser.add_argument("run", help="run folder; its world must offer branches (bullet, mujoco, toy)")
    parser.add_argument(
        "--pushes", type=int, default=PUSHES, metavar="N", help=f"tried from each state ({PUSHES})"
    )
    parser.add_argument("--out", metavar="FOLDER", help="where to write (default: the run's folder)")
    own_classes.add(parser)
    parser.add_argument("--overwrite", action="store_true", help="begin again, whatever files are there")
    given = parser.parse_args(argv)
    own_classes.use(given)
    from deformpush.experiment.console import Progress, orderly_end, stop_prevails, warn
    from deformpush.experiment.run import existing
    from deformpush.experiment.true_regret import measure
    from deformpush.record.files import write_whole
    from deformpush.study import regret_figure, regret_text

    folder = existing(given.run)
    out = folder.path if given.out is None else Path(given.out)
    table, trials, picture = out / REGRET, out / TRIALS, out / regret_figure.FILE
    output.make_room([table], overwrite=True)
    try:
        with output.writing(table), orderly_end(), stop_prevails():
            already = measure(folder, out, given.pushes, given.overwrite, Progress, warn)
    except KeyboardInterrupt:
        again = shlex.join(["python", "-m", "deformpush", "regret", *argv])
        print(f"{table}: stopped; `{again}` goes on", file=sys.stderr)
        raise
    rows = read(table)
    if already:
        print(f"{table}: {already} of {len(rows['k'])} pushes were there already")
    print(regret_text.text(folder.path, rows))
    with output.writing(picture):
        write_whole(picture, regret_figure.draw(rows, read_trials(trials)))
    print(f"written:     {table}, {trials.name}, {picture.name}")
    return 0
