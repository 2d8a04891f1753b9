"""The verb `replay`: make the pushes of a run again and say whether all comes out the same."""

import argparse
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from deformpush.cli import own_classes
from deformpush.errors import UserError

if TYPE_CHECKING:
    from deformpush.experiment.replayed import Replay
    from deformpush.experiment.setup import Setup


def main(argv: Sequence[str]) -> int:
    """Replay a run; exit code 0 when it is identical, 1 when it differs.

    Raises:
        UserError: there is no run to replay, or the folder to record into is taken.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush replay",
        description="Make the pushes of a run again, from its config.yaml and pushes.csv, and compare every "
        "state to the last bit: `identical`, or where it first differs, whether in a last bit or really, and "
        "how the versions and kernels that made it differ from those here.",
        epilog="example: python -m deformpush replay runs/mine --into runs/mine-again record=full",
    )
    parser.add_argument("run", help="run folder")
    parser.add_argument("record", nargs="*", help="with --into: how to record, such as record=full")
    parser.add_argument("--into", metavar="FOLDER", help="record the replay there; it may hold more")
    parser.add_argument(
        "--from", type=int, default=1, metavar="K", dest="first",
        help="begin with push K, in the state before it that the world saved; the optimizer is not asked",
    )  # fmt: skip
    own_classes.add(parser)
    given = parser.parse_intermixed_args(argv)
    own_classes.use(given)
    if given.record and not given.into:
        raise UserError(f"{' '.join(given.record)}: recording needs --into FOLDER")
    if given.into and given.first != 1:
        raise UserError(f"--from {given.first}: not with --into, which records a run from its beginning")
    return _replay(Path(given.run), given.into, given.record, given.first)


def _replay(path: Path, into: str | None, settings: Sequence[str], first: int) -> int:
    from deformpush.experiment.assemble import begin
    from deformpush.experiment.replayed import Replay
    from deformpush.experiment.run import existing, put_up, read_unfinished, reload
    from deformpush.experiment.take_up import go_before

    folder = existing(path)
    setup = reload(folder)
    recorded = read_unfinished(folder)
    if not recorded.rows:
        raise UserError(f"{folder.table}: holds no push to replay")
    if first != 1 and not 1 <= first <= recorded.pushes:
        raise UserError(f"--from {first}: must be 1 to {recorded.pushes}, the pushes of {folder.path}")
    if into is not None:
        setup = _recorded_as(setup, settings)
    optimizer, cell = put_up(setup, folder)
    with closing(cell.world):
        episode = begin(setup, cell, optimizer)
        if first > 1:
            go_before(episode, recorded, first)
        found = Replay(episode, recorded)
        if into is None:
            for _ in found.follow(maps=False):
                pass
        else:
            _record(setup, found, into)
    print(found.text())
    return 0 if found.identical else 1


def _recorded_as(setup: "Setup", settings: Sequence[str]) -> "Setup":
    """The same run, recorded as these settings of the group `record` say."""
    from deformpush.config.compose import compose
    from deformpush.experiment.setup import read

    for text in settings:
        if text.partition("=")[0].partition(".")[0] != "record":
            raise UserError(f"{text}: a replay changes nothing but record=OPTION and record.KEY=VALUE")
    other = read(compose(settings))
    return replace(setup, record=other.record, values={**setup.values, "record": other.values["record"]})


def _record(setup: "Setup", found: "Replay", into: str) -> None:
    """Replay into a run folder of its own."""
    from deformpush.experiment.assemble import describe
    from deformpush.experiment.recorder import Recorder
    from deformpush.experiment.take_up import saves
    from deformpush.record.folder import RunFolder
    from deformpush.study import run_figure

    episode, recorded = found.episode, found.recorded
    recorder = Recorder(RunFolder.create(into, setup.yaml), setup.record, saves(episode.cell))
    with recorder:
        recorder.open(describe(setup, episode), episode.record, episode.optimizer.state)
        for record in found.follow(setup.record.maps):
            if record.k:
                recorder(record)
        ending = episode.ending
        status = "budget" if ending is None else ending.status
        recorder.close(status, f"replay of {recorded.folder.path}, {recorded.pushes} pushes")
    if setup.record.figures:
        run_figure.draw(recorder.folder)
