"""Makes a run from its components, or continues the one in a folder."""

import logging
import shlex
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from copy import deepcopy
from pathlib import Path
from typing import Any

from deformpush import loop
from deformpush.cell.cell import Cell
from deformpush.errors import TroubleError, UserError
from deformpush.experiment import goal_picture
from deformpush.experiment.assemble import begin, build_cell, build_optimizer, describe
from deformpush.experiment.console import Progress, Verbosity, orderly_end, say, stop_prevails, warn
from deformpush.experiment.recorder import Recorder
from deformpush.experiment.setup import PLAIN, Setup, read
from deformpush.experiment.take_up import saves, take_up
from deformpush.loop import Episode
from deformpush.optimizer.base import Optimizer
from deformpush.record import unfinished
from deformpush.record.folder import RunFolder
from deformpush.record.saved_config import SavedConfigError, read_config
from deformpush.record.settings import RecordSettings
from deformpush.record.status import run_status
from deformpush.record.summary import Summary
from deformpush.record.unfinished import UnfinishedRun
from deformpush.study import run_figure

log = logging.getLogger(__name__)


def make_run(setup: Setup, path: str | Path, verbosity: Verbosity = Verbosity.FULL) -> Summary:
    """Make the run that `setup` describes, in the folder `path`.

    Raises:
        UserError: a setting is wrong or the folder cannot be used; no result has been written.
        TroubleError: the results could not be written to the end; what there is stays.
    """
    setup = goal_picture.looked_at(setup)
    optimizer = build_optimizer(setup)
    cell = build_cell(setup)
    with closing(cell.world), orderly_end():
        episode = begin(setup, cell, optimizer)
        folder = RunFolder.create(path, setup.yaml)
        recorder = Recorder(folder, setup.record, saves(cell))
        info = describe(setup, episode)
        if setup.object.slab.outline.reversed:
            log.warning("object.outline: runs clockwise; it is taken the other way round")
        log.info("%s: %d pushes at most, into %s", info.title, info.max_pushes, folder.path)
        with (
            Progress(info.max_pushes, verbosity) as progress,
            _writable(folder.path),
            recorder,
            stop_prevails(),
        ):
            recorder.open(info, episode.record, optimizer.state)
            return _finish(episode, recorder, progress, verbosity)


def resume(path: str | Path, verbosity: Verbosity = Verbosity.FULL) -> Summary | None:
    """Continue the run in `path` as if it had never stopped; None if there is nothing left to do.

    It goes on from a state that the world saved, or makes all pushes again where there is none; the optimizer
    takes up its checkpoint. Nothing in the folder changes before all is as it was.

    Raises:
        UserError: there is no run to continue, or another process works on it.
        DivergedError: the pushes do not repeat themselves.
    """
    folder = existing(path)
    if (ended := run_status(folder)).state == "done":
        print(f"{folder.path}: nothing to resume, it ended: {ended.text}")
        return None
    setup = reload(folder)
    lock = folder.lock()
    try:
        left = read_unfinished(folder)
        if not left.current:
            raise UserError(f"{folder.table}: of an older version, whose runs can only be looked at")
        optimizer, cell = put_up(setup, folder)
        with closing(cell.world), orderly_end(), Progress(setup.max_pushes, verbosity) as progress:
            if left.rows:
                episode, recorder = take_up(setup, cell, optimizer, left, [progress], warn)
            else:
                episode = begin(setup, cell, optimizer)
                recorder = Recorder(folder, setup.record, saves(cell))
            info = describe(setup, episode)
            with _writable(folder.path), recorder, stop_prevails():
                if left.rows:
                    log.info("%s: taken up after push %d, in %s", info.title, left.pushes, folder.path)
                    recorder.reopen(info, left, optimizer.state, lock)
                else:
                    recorder.open(info, episode.record, optimizer.state, lock)
                return _finish(episode, recorder, progress, verbosity)
    finally:
        lock.release()


def _finish(episode: Episode, recorder: Recorder, progress: Progress, verbosity: Verbosity) -> Summary:
    """Push to the end, draw the figures and say how it went."""
    ending = loop.run(episode, recorder.settings.maps, [recorder, progress])
    summary = recorder.close(ending.status, ending.reason)
    without: OSError | None = None
    if recorder.settings.figures:
        try:
            run_figure.draw(recorder.folder)
        except OSError as error:
            without = error
    log.info("%s after %d pushes: %s", summary.status, summary.pushes, summary.reason)
    progress.close()
    say(summary, recorder.folder.path, verbosity)
    if without is not None:
        why = without.strerror or without
        raise TroubleError(f"{recorder.folder.path}: the run is whole, but its figure lacks ({why})")
    return summary


def existing(path: str | Path) -> RunFolder:
    """The folder of a run that was begun.

    Raises:
        UserError: there is no such folder, or no run in it.
    """
    folder = RunFolder(Path(path))
    if not folder.path.is_dir():
        raise UserError(f"{folder.path}: no such folder")
    if not folder.config.exists():
        raise UserError(f"{folder.path}: no {folder.config.name}, so there is no run to take up")
    return folder


def read_unfinished(folder: RunFolder) -> UnfinishedRun:
    """What a run left, for those who take it up.

    Raises:
        UserError: its table cannot be read.
    """
    try:
        return unfinished.read(folder)
    except OSError as error:
        raise UserError(f"{folder.table}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise UserError(str(error)) from error


def reload(folder: RunFolder) -> Setup:
    """The components of the run in a folder.

    Raises:
        UserError: its configuration is damaged, or of a version that this one does not understand.
    """
    with about(folder.config):
        values = saved_settings(folder)
        keys, known = {*values}, {*Setup.GROUPS, *PLAIN} - {"values"}
        if "sim" in keys:
            raise UserError("of version 0.1; compare, report and view take it, resume and replay do not")
        if keys != known:
            differing = ", ".join(sorted(keys ^ known))
            raise UserError(f"{differing}: missing or unknown; of another version, or no run's")
        if isinstance(
            values["record"], dict
        ):  # runs of versions that saved no states are taken up all the same
            values["record"].setdefault("world_states", RecordSettings.world_states)
        return read(values)


def saved_settings(folder: RunFolder) -> dict[str, Any]:
    """What the config.yaml of a run says, plain values only.

    Raises:
        UserError: it cannot be read, or holds what no run writes.
    """
    with about(folder.config):
        try:
            return deepcopy(read_config(folder.config))  # which shares what it gives
        except OSError as error:
            raise UserError(f"cannot be read ({error.strerror})") from error
        except SavedConfigError as error:
            raise UserError(str(error)) from error


def put_up(setup: Setup, folder: RunFolder) -> tuple[Optimizer, Cell]:
    """Optimizer and cell of a run in a folder, as they were before its first push.

    Raises:
        UserError: they do not go together, or the world cannot hold the object; names config.yaml.
    """
    with about(folder.config):
        return build_optimizer(setup), build_cell(setup)


@contextmanager
def about(file: Path) -> Iterator[None]:
    """Name the file whose settings are complained of."""
    try:
        yield
    except UserError as error:
        text = str(error)
        raise UserError(text if text.startswith(str(file)) else f"{file}: {text}") from error


@contextmanager
def _writable(path: Path) -> Iterator[None]:
    """Say in one line that a run stopped or cannot be written any more, and how it goes on."""
    hint = f"`python -m deformpush resume {shlex.quote(str(path))}` goes on"
    try:
        yield
    except KeyboardInterrupt:
        print(f"{path}: stopped; {hint}", file=sys.stderr)
        raise
    except OSError as error:
        why = error.strerror or str(error)
        raise TroubleError(
            f"{path}: cannot be written any more ({why}); the pushes before are kept, {hint}"
        ) from error
