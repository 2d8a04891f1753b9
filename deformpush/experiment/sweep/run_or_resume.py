"""One run of a sweep: made, continued, left alone, or made once more, as its folder asks for."""

import logging
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from omegaconf import DictConfig

from deformpush.config import build as config
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.console import Verbosity
from deformpush.experiment.run import make_run, resume, saved_settings
from deformpush.experiment.setup import read
from deformpush.record.files import write_whole
from deformpush.record.finished import flat
from deformpush.record.folder import REFUSED, RESULTS, RunFolder
from deformpush.record.status import run_status
from deformpush.record.summary import Summary

log = logging.getLogger(__name__)


class FailedBeforeError(TroubleError):
    """A run of a sweep failed at an earlier time and is not made once more."""


def run_or_resume(
    cfg: DictConfig, path: Path, retry: bool, verbosity: Verbosity = Verbosity.ONE_LINE
) -> Summary | None:
    """Bring the run in the folder `path` to its end; one that has ended is left alone, and gives None.

    Args:
        cfg: what the run is to be.
        path: its folder.
        retry: whether one that failed is made once more; what it left moves into a hidden folder inside.
        verbosity: how much it says.

    Raises:
        UserError: the settings do not fit, or the folder holds a run of other settings.
        FailedBeforeError: the run failed at an earlier time.
    """
    folder = RunFolder(path)
    was = run_status(folder)
    if was.state == "running":
        log.info("left alone, another process is at work: %s", path)
        return None
    if was.state not in ("pending", "refused"):
        _same_settings(cfg, folder)
    if was.state == "done":
        log.info("left alone, %s: %s", was.text, path)
        return None
    if was.state == "failed" and not retry:
        raise FailedBeforeError(
            f"{path.name}: failed before ({was.text}); sweep.retry=true makes it once more"
        )
    if was.state == "failed":
        _put_aside(folder)
    if was.state == "interrupted":
        return resume(path, verbosity)
    try:
        summary = make_run(read(cfg), path, verbosity)
    except TroubleError:
        raise
    except UserError as error:
        with suppress(OSError):
            path.mkdir(parents=True, exist_ok=True)
            write_whole(path / REFUSED, f"{error}\n".encode())
        raise
    (path / REFUSED).unlink(missing_ok=True)
    return summary


def _same_settings(cfg: DictConfig, folder: RunFolder) -> None:
    """Refuse a folder whose run was made with other settings; how it was recorded does not matter."""
    if not folder.config.exists():
        return
    now, then = map(_settings, (config.plain(cfg), saved_settings(folder)))
    differing = [key for key in {**now, **then} if now.get(key, ...) != then.get(key, ...)]
    if differing:
        key = min(differing)
        raise UserError(
            f"{folder.path}: holds a run of other settings ({key} was {then.get(key, 'missing')}, is "
            f"{now.get(key, 'missing')}); remove it, or name another hydra.sweep.dir"
        )


def _settings(values: Mapping[str, Any]) -> Mapping[str, Any]:
    return {
        key: value for key, value in flat(values).items() if not key.startswith(("record.", "options.record"))
    }


def _put_aside(folder: RunFolder) -> None:
    """Move the results of a failed run into .failed-1/, .failed-2/, ... inside its folder."""
    number = 1
    while (aside := folder.path / f".failed-{number}").exists():
        number += 1
    aside.mkdir()
    for name in RESULTS:
        if (folder.path / name).exists():
            (folder.path / name).replace(aside / name)
