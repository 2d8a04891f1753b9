"""The verb `replay`: make the pushes of a run again and say whether all comes out the same."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deformpush.errors import UserError

if TYPE_CHECKING:
    from omegaconf import DictConfig

    from deformpush.loop import Episode
    from deformpush.push_record import PushRecord
    from deformpush.record.unfinished import Past


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
    parser.add_argument("--config-dir", help="folder of your own classes, if the run used any")
    given = parser.parse_intermixed_args(argv)
    if given.config_dir:
        sys.path.append(given.config_dir)
    if given.record and not given.into:
        raise UserError(f"{' '.join(given.record)}: recording needs --into FOLDER")
    return _replay(Path(given.run), given.into, given.record)


def _replay(path: Path, into: str | None, settings: Sequence[str]) -> int:
    from deformpush.experiment import run as execution
    from deformpush.loop import Episode, start
    from deformpush.record.folder import RunFolder

    folder = RunFolder(path)
    if not path.is_dir():
        raise UserError(f"{path}: no such folder")
    cfg = execution.reload(folder)
    past = execution.read_past(folder)
    if not past.rows:
        raise UserError(f"{folder.table}: holds no push to replay")
    if into is not None:
        cfg.record = _record(settings)
    cell = execution.rebuild(cfg, folder)
    with closing(cell.world):
        episode = Episode(cell, start(cell))
        if into is None:
            found = _Findings(episode, past)
            for _ in found.follow(maps=False):
                pass
        else:
            found = _recorded(cfg, episode, past, into)
    print(found.text())
    return 0 if found.identical else 1


def _record(settings: Sequence[str]) -> "DictConfig":
    """The recording that is asked for: settings of the group `record` and no other."""
    from deformpush.config.compose import compose

    for text in settings:
        if text.partition("=")[0].partition(".")[0] != "record":
            raise UserError(f"{text}: a replay changes nothing but record=OPTION and record.KEY=VALUE")
    record: DictConfig = compose(settings).record
    return record


def _recorded(cfg: "DictConfig", episode: "Episode", past: "Past", into: str) -> "_Findings":
    """Replay into a run folder of its own."""
    from deformpush.config import build as config
    from deformpush.experiment import assemble
    from deformpush.record.folder import RunFolder

    recorder = config.build(cfg.record, folder=RunFolder.create(into, config.dump(cfg)))
    found = _Findings(episode, past)
    with recorder:
        recorder.open(assemble.describe(cfg, episode), episode.first)
        for record in found.follow(recorder.maps):
            if record.k:
                recorder.push(record, episode.cell.optimizer.state())
        recorder.close(episode.ending()[0], f"replay of {past.folder.path}, {past.pushes} pushes")
    return found


class _Findings:
    """What a replay brings to light."""

    def __init__(self, episode: "Episode", past: "Past") -> None:
        self._episode, self._past = episode, past
        self._contours = _contours(past)
        self._first: str | None = None
        self._largest = 0.0
        self._otherwise: str | None = None

    def follow(self, maps: bool) -> "Iterator[PushRecord]":
        """Make the pushes one after the other and keep what is different."""
        import numpy as np

        from deformpush.experiment.repeat import replay, wants

        for record, other in replay(self._episode, self._past, maps):
            k = record.k
            if k < len(self._contours):
                apart = float(np.abs(record.after.contour - self._contours[k]).max())
                self._largest = max(self._largest, apart)
                other = other or (f"the contour differs by {_length(apart)}" if apart else None)
            if other is not None and self._first is None:
                self._first = f"push {k}: {other}"
            made = self._episode.wanted
            if k and self._otherwise is None and made is not None:
                decision = self._past.decision(k)
                if not np.array_equal(made, (decision.kappa, decision.d)):
                    self._otherwise = f"at push {k} the optimizer {wants(self._episode)}, it pushed kappa = "
                    self._otherwise += f"{decision.kappa:.6g}, d = {decision.d * 1e3:.6g} mm"
            yield record

    @property
    def identical(self) -> bool:
        """Whether nothing differed."""
        return self._first is None and self._otherwise is None

    def text(self) -> str:
        """What to say."""
        pushes = f"{self._past.pushes} push{'' if self._past.pushes == 1 else 'es'}"
        if self._first is not None:
            text = f"differs first at {self._first}"
            if len(self._contours):
                text += f"; at most {_length(self._largest)} between the contours of {pushes}"
        else:
            told = "errors and contours" if len(self._contours) else "errors"
            text = f"identical: {pushes}, {told} to the last bit"
        return text if self._otherwise is None else f"{text}\ndecides otherwise: {self._otherwise}"


def _contours(past: "Past") -> Any:
    """The recorded contours `(K+1, M, 2)`, or none where they cannot be read."""
    from deformpush.record.poses import read_trace

    try:
        return read_trace(past.folder.contours).contours
    except FileNotFoundError:
        return ()
    except (OSError, ValueError) as error:
        print(f"without the contours: {error}", file=sys.stderr)
        return ()


def _length(metres: float) -> str:
    return f"{metres * 1e3:.3g} mm"
