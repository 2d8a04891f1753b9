"""From a configuration, or a run folder, to a run made: what `python -m deformpush` and `resume` do."""

import logging
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path

from omegaconf import DictConfig

from deformpush.cell.cell import Cell
from deformpush.config import build as config
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.assemble import build_cell, describe
from deformpush.experiment.console import Progress, Voice, orderly_end, say
from deformpush.experiment.recorder import Recorder
from deformpush.experiment.repeat import catch_up
from deformpush.loop import Episode, run, start
from deformpush.record import unfinished as records
from deformpush.record.folder import RunFolder
from deformpush.record.status import condition

log = logging.getLogger(__name__)

EXIT_CODES = {"reached": 0, "budget": 0, "damaged": 0, "failed": 1, "interrupted": 130}


def execute(cfg: DictConfig, run_dir: str | Path, voice: Voice = Voice.FULL) -> int:
    """Run what `cfg` describes in `run_dir` and return the exit code.

    Raises:
        UserError: a setting is wrong or the folder cannot be used; no result has been written.
        TroubleError: the results could not be written to the end; what there is stays.
    """
    config.check(cfg)
    cell = build_cell(cfg)
    with closing(cell.world), orderly_end():
        episode = Episode(cell, start(cell))
        folder = RunFolder.create(run_dir, config.dump(cfg))
        recorder = config.build(cfg.record, folder=folder)
        info = describe(cfg, episode)
        log.info("%s: %d pushes at most, into %s", info.title, cell.max_pushes, folder.path)
        with Progress(cell.max_pushes, voice) as progress:
            return _finish(episode, recorder, partial(recorder.open, info, episode.first), progress, voice)


def resume(run_dir: str | Path, voice: Voice = Voice.FULL) -> int:
    """Continue the run in `run_dir`, as if it had never stopped, and return the exit code.

    The pushes that were made are made again by the simulator, whose soft body can be restored in no other
    exact way; the optimizer takes up its checkpoint. Nothing in the folder changes before all is as it was.

    Raises:
        UserError: there is no run to continue, or another process works on it.
        DivergedError: the pushes do not repeat themselves.
    """
    folder = RunFolder(Path(run_dir))
    if not folder.path.is_dir():
        raise UserError(f"{folder.path}: no such folder")
    if (ended := condition(folder)).state == "done":
        print(f"{folder.path}: nothing to resume, it ended: {ended.text}")
        return 0
    cfg = reload(folder)
    lock = folder.lock()
    try:
        past = read_past(folder)
        if not past.current:
            raise UserError(
                f"{folder.table}: of an older version, whose runs can be replayed but not resumed"
            )
        cell = rebuild(cfg, folder)
        with closing(cell.world), orderly_end():
            episode = Episode(cell, start(cell))
            recorder = config.build(cfg.record, folder=folder)
            info = describe(cfg, episode)
            with Progress(cell.max_pushes, voice) as progress:
                if not past.rows:
                    begin: Callable[[], object] = partial(recorder.open, info, episode.first, lock)
                else:
                    again = catch_up(episode, past, progress)
                    log.info("%s: taken up after push %d, in %s", info.title, past.pushes, folder.path)
                    begin = partial(recorder.reopen, info, past, again, lock)
                return _finish(episode, recorder, begin, progress, voice)
    finally:
        lock.release()


def read_past(folder: RunFolder) -> records.Past:
    """What a run left, for those who take it up.

    Raises:
        UserError: its table cannot be read.
    """
    try:
        return records.read(folder)
    except OSError as error:
        raise UserError(f"{folder.table}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise UserError(str(error)) from error


def reload(folder: RunFolder) -> DictConfig:
    """The configuration a run was made with.

    Raises:
        UserError: there is none, it is damaged, or of a version that this one does not understand.
    """
    if not folder.config.exists():
        raise UserError(f"{folder.path}: no {folder.config.name}, so there is no run to take up")
    cfg = config.load(folder.config)
    with _said_of(folder.config):
        config.check(cfg)
        if missing := {*config.GROUPS, config.OPTIONS, *config.PLAIN} - set(cfg):
            raise UserError(f"{', '.join(sorted(missing))}: missing; of another version, or no run's")
    if unknown := set(map(str, cfg)) - {*config.GROUPS, config.OPTIONS, *config.PLAIN}:
        print(
            f"{folder.config}: {', '.join(sorted(unknown))}: without effect in this version", file=sys.stderr
        )
    return cfg


def rebuild(cfg: DictConfig, folder: RunFolder) -> Cell:
    """The cell of a run that was made with `cfg`.

    Raises:
        UserError: a setting is not understood; the message names the file.
    """
    with _said_of(folder.config):
        return build_cell(cfg)


@contextmanager
def _said_of(file: Path) -> Iterator[None]:
    """Name the file whose settings are complained of."""
    try:
        yield
    except UserError as error:
        raise UserError(f"{file}: {error}") from error


def _finish(
    episode: Episode, recorder: Recorder, begin: Callable[[], object], progress: Progress, voice: Voice
) -> int:
    """Run to the end, say how it went and return the exit code."""
    path = recorder.folder.path
    try:
        summary = run(episode, recorder, begin, progress)
    except KeyboardInterrupt:
        print(f"{path}: stopped; {_resume_hint(path)}", file=sys.stderr)
        raise
    except OSError as error:
        why = error.strerror or str(error)
        raise TroubleError(
            f"{path}: cannot be written any more ({why}); the pushes before are kept, {_resume_hint(path)}"
        ) from error
    log.info("%s after %d pushes: %s", summary.status, summary.pushes, summary.reason)
    progress.close()
    say(summary, path, voice)
    return EXIT_CODES[summary.status]


def _resume_hint(path: Path) -> str:
    return f"`python -m deformpush resume {shlex.quote(str(path))}` goes on"
