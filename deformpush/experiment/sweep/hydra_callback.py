"""What happens when Hydra begins a sweep, in the process that sends out the runs."""

from collections.abc import Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import fields
from pathlib import Path
from typing import Any

from hydra.conf import HydraConf
from hydra.core.hydra_config import HydraConfig
from hydra.experimental.callback import Callback
from omegaconf import OmegaConf, flag_override
from omegaconf.errors import OmegaConfBaseException

from deformpush.config.default_world import tell_default
from deformpush.config.groups import check_options
from deformpush.errors import UserError
from deformpush.experiment.sweep import launchers, manifest
from deformpush.experiment.sweep.manifest import Job
from deformpush.experiment.sweep.names import short

begun: list[Path] = []
"""Folders of the sweeps that this process began."""
absent: list[Path] = []
"""Folder of the run or sweep and those above it that were not there before, the innermost first."""


SUBDIR = "${run_name:${hydra.job.override_dirname}}"
"""What conf/config.yaml has for `hydra.sweep.subdir`."""


class CannotBeginError(BaseException):
    """Carries a `UserError` past Hydra, which makes a warning of every `Exception` of a callback."""

    def __init__(self, error: UserError) -> None:
        super().__init__(str(error))
        self.error = error


class ListRuns(Callback):
    """Looks at Hydra's own settings before it makes a folder, and lists the runs of a sweep for `status`."""

    def on_run_start(self, config: Any, **_: Any) -> None:
        """Remember which folders are not there yet.

        Raises:
            CannotBeginError: a setting of Hydra's own will not do.
        """
        _look(config, "run")

    def on_multirun_start(self, config: Any, **_: Any) -> None:
        """Write sweep.json and say where the runs go.

        Raises:
            CannotBeginError: a setting of Hydra's own will not do, the launcher is not installed, or the
                folder cannot be used.
        """
        _look(config, "sweep")
        _command_line_wins(config)
        launcher, target = config.hydra.runtime.choices["hydra/launcher"], config.hydra.launcher._target_
        if target.endswith("RayLauncher"):
            _name_folder_in_full(config)
        folder, jobs = Path(str(config.hydra.sweep.dir)), _jobs(config)
        try:
            launchers.check_installed(launcher, target)
            launchers.wait_for_all(target)
            manifest.write(folder, jobs)
        except UserError as error:
            raise CannotBeginError(error) from error
        except OSError as error:
            why = error.strerror or error
            problem = UserError(f"hydra.sweep.dir = {folder}: cannot be used for a sweep: {why}")
            raise CannotBeginError(problem) from error
        compose_kinds_only()
        begun.append(folder)
        print(f"sweep of {len(jobs) or 'some'} runs, in {folder}", flush=True)


def _look(config: Any, kind: str) -> None:
    """Check Hydra's own settings, and remember which folders are not there yet.

    Args:
        config: the whole configuration.
        kind: run or sweep.
    """
    hydra = config.hydra
    try:
        check_options(hydra.runtime.choices)
        tell_default(hydra.runtime.choices, hydra.overrides.task)
        groups = {group.removeprefix("hydra/") for group in hydra.runtime.choices}
        if strange := sorted(set(map(str, hydra)) - groups - {item.name for item in fields(HydraConf)}):
            raise UserError(f"hydra.{strange[0]}: unknown; --hydra-help says what there is")
        if (subdir := hydra.output_subdir) is not None:
            raise UserError(
                f"hydra.output_subdir = {subdir}: must stay null; a run keeps its config.yaml itself"
            )
        as_written: Any = OmegaConf.to_container(hydra.sweep, resolve=False)
        if (subdir := as_written.get("subdir")) != SUBDIR:
            raise UserError(f"hydra.sweep.subdir = {subdir}: must stay {SUBDIR}; runs are found by that name")
        # The folder's name may ask for it. A copy: what is set there can be changed no more.
        HydraConfig.instance().set_config(deepcopy(config))
        folder = Path(str(hydra[kind].dir)).absolute()
        absent[:] = [path for path in (folder, *folder.parents) if not path.exists()]
    except UserError as error:
        raise CannotBeginError(error) from error
    except OmegaConfBaseException as error:
        raise CannotBeginError(UserError(f"{error.full_key}: {str(error).splitlines()[0]}")) from error


def leave_nothing() -> None:
    """Remove the folders that were made for what never began. One that holds anything stays."""
    with suppress(OSError):
        for path in absent:
            path.rmdir()


def compose_kinds_only() -> None:
    """Let Hydra compose one run of every kind before the first begins, to find mistakes early, and not all.

    Composing takes a quarter of a second a run, and the other cores wait for it. Runs that differ in numbers
    alone are of one kind: a number chooses no file. One that does not fit refuses its own run.
    """
    from hydra.plugins.sweeper import Sweeper

    whole = getattr(Sweeper.validate_batch_is_legal, "whole", Sweeper.validate_batch_is_legal)

    def kinds(self: Sweeper, batch: Sequence[Sequence[str]]) -> None:
        whole(self, list({tuple(map(_kind, job)): job for job in batch}.values()))

    kinds.whole = whole  # type: ignore[attr-defined]
    Sweeper.validate_batch_is_legal = kinds  # type: ignore[method-assign]


def _kind(override: str) -> str:
    """What of an override may decide whether a configuration can be composed: all but a number."""
    key, _, value = override.partition("=")
    try:
        float(value)
    except ValueError:
        return override
    return key


def _command_line_wins(config: Any) -> None:
    """Drop a study's range of a setting that the command line gives too; Hydra would make a run for each."""
    params = config.hydra.sweeper.get("params") or {}
    asked = {text.partition("=")[0].lstrip("+~") for text in config.hydra.overrides.task}
    with flag_override(config, ["readonly", "struct"], False):
        for key in asked & {str(name) for name in params}:
            del params[key]


def _name_folder_in_full(config: Any) -> None:
    """Make the sweep's folder absolute: workers of Ray may stand in another folder."""
    folder = str(Path(str(config.hydra.sweep.dir)).absolute())
    quoted = folder.replace("\\", "\\\\").replace("'", "\\'")
    with flag_override(config, ["readonly", "struct"], False):
        config.hydra.sweep.dir = folder
        kept = [text for text in config.hydra.overrides.hydra if not text.startswith("hydra.sweep.dir=")]
        config.hydra.overrides.hydra = [*kept, f"hydra.sweep.dir='{quoted}'"]


def _jobs(config: Any) -> list[Job]:
    """The runs that the sweep's settings stand for, as Hydra's own sweeper will split them."""
    from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
    from hydra.core.override_parser.overrides_parser import OverridesParser

    if not str(config.hydra.sweeper._target_).endswith("BasicSweeper"):
        return []  # other sweepers choose their runs as they go
    params = [f"{key}={value}" for key, value in (config.hydra.sweeper.params or {}).items()]
    parsed = OverridesParser.create().parse_overrides([*params, *config.hydra.overrides.task])
    return [Job(_folder(config, job), job) for job in BasicSweeper.split_arguments(parsed, None)[0]]


def _folder(config: Any, overrides: list[str]) -> str:
    """What `hydra.sweep.subdir` comes to for a run with these overrides."""
    excluded = set(config.hydra.job.config.override_dirname.exclude_keys)
    return short(",".join(sorted(text for text in overrides if text.partition("=")[0] not in excluded)))
