"""The verb `replay`: make the pushes of a run again and say whether all comes out the same."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deformpush.errors import UserError

if TYPE_CHECKING:
    from deformpush.experiment.setup import Setup
    from deformpush.loop import Episode
    from deformpush.push_record import PushRecord
    from deformpush.record.unfinished import UnfinishedRun


def main(argv: Sequence[str]) -> int:
    """Replay a run; exit code 0 when it is identical, 1 when it differs.

    Raises:
        UserError: there is no run to replay, or the folder to record into is taken.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush replay",
        description="Make the pushes of a run again, from its config.yaml and pushes.csv, and compare every "
        "state to the last bit: `identical`, or where and by how much it first differs.",
        epilog="example: python -m deformpush replay runs/mine --into runs/mine-again record=full",
    )
    parser.add_argument("run", help="run folder")
    parser.add_argument("record", nargs="*", help="with --into: how to record, such as record=full")
    parser.add_argument("--into", metavar="FOLDER", help="record the replay there; it may hold more")
    parser.add_argument(
        "--from", type=int, default=1, metavar="K", dest="first",
        help="begin with push K, in the state before it that the world saved; the optimizer is not asked",
    )  # fmt: skip
    parser.add_argument("--config-dir", help="folder of your own classes, if the run used any")
    given = parser.parse_intermixed_args(argv)
    from deformpush.config.locate import use_config_dir

    if given.config_dir:
        use_config_dir(given.config_dir)
    if given.record and not given.into:
        raise UserError(f"{' '.join(given.record)}: recording needs --into FOLDER")
    if given.into and given.first != 1:
        raise UserError(f"--from {given.first}: not with --into, which records a run from its beginning")
    return _replay(Path(given.run), given.into, given.record, given.first)


def _replay(path: Path, into: str | None, settings: Sequence[str], first: int) -> int:
    from deformpush.experiment.assemble import begin, build_cell, build_optimizer
    from deformpush.experiment.run import about, existing, read_unfinished, reload
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
    with about(folder.config):
        optimizer, cell = build_optimizer(setup), build_cell(setup)
    with closing(cell.world):
        episode = begin(setup, cell, optimizer)
        if first > 1:
            go_before(episode, recorded, first)
        found = _Findings(episode, recorded)
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


def _record(setup: "Setup", found: "_Findings", into: str) -> None:
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


class _Findings:
    """What a replay brings to light."""

    def __init__(self, episode: "Episode", recorded: "UnfinishedRun") -> None:
        self.episode, self.recorded = episode, recorded
        self._begins = episode.record.k
        self._contours = _contours(recorded)
        self._first: str | None = None
        self._largest = 0.0
        self._otherwise: str | None = None

    def follow(self, maps: bool) -> "Iterator[PushRecord]":
        """Make the pushes one after the other and keep what is different."""
        import numpy as np

        from deformpush.experiment.repeat import replay, wants

        for record, other in replay(self.episode, self.recorded, maps):
            k = record.k
            if k < len(self._contours):
                apart = float(np.abs(record.view.seen.contour - self._contours[k]).max())
                self._largest = max(self._largest, apart)
                other = other or (f"the contour differs by {_length(apart)}" if apart else None)
            if other is not None and self._first is None:
                self._first = f"push {k}: {other}"
            made = self.episode.wanted
            if k and self._otherwise is None and made is not None:
                u = self.recorded.proposal(k).u
                if not np.array_equal(made, u):
                    self._otherwise = f"at push {k} the optimizer {wants(self.episode)}, it pushed kappa = "
                    self._otherwise += f"{u[0]:.6g}, d = {u[1] * 1e3:.6g} mm"
            yield record

    @property
    def identical(self) -> bool:
        """Whether nothing differed."""
        return self._first is None and self._otherwise is None

    def text(self) -> str:
        """What to say."""
        count = self.recorded.pushes - self._begins
        pushes = f"{count} push{'' if count == 1 else 'es'}"
        if self._first is not None:
            text = f"differs first at {self._first}"
            if len(self._contours):
                text += f"; at most {_length(self._largest)} between the contours of {pushes}"
        else:
            told = "errors and contours" if len(self._contours) else "errors"
            text = f"identical: {pushes}, {told} to the last bit"
        return text if self._otherwise is None else f"{text}\ndecides otherwise: {self._otherwise}"


def _contours(recorded: "UnfinishedRun") -> Any:
    """The recorded contours `(K+1, M, 2)`, or none where they cannot be read."""
    from deformpush.record.poses import read_poses

    try:
        return read_poses(recorded.folder.contours).contours
    except FileNotFoundError:
        return ()
    except (OSError, ValueError) as error:
        print(f"without the contours: {error}", file=sys.stderr)
        return ()


def _length(metres: float) -> str:
    return f"{metres * 1e3:.3g} mm"
