"""What happens when Hydra begins a sweep, in the process that sends out the runs."""

from pathlib import Path
from typing import Any

from hydra.experimental.callback import Callback

from deformpush.errors import UserError
from deformpush.sweep import ledger
from deformpush.sweep.ledger import Job
from deformpush.sweep.names import short

begun: list[Path] = []
"""Folders of the sweeps that this process began."""


class Beginning(Callback):
    """Lists the runs of a sweep before the first begins, so that `status` knows what is still to come."""

    def on_multirun_start(self, config: Any, **_: Any) -> None:
        """Write sweep.json and say where the runs go."""
        folder, jobs = Path(str(config.hydra.sweep.dir)), _jobs(config)
        begun.append(folder)
        try:
            ledger.write(folder, jobs)
        except OSError as error:
            why = error.strerror or error
            raise UserError(f"hydra.sweep.dir = {folder}: cannot be used for a sweep: {why}") from error
        print(f"sweep of {len(jobs) or 'some'} runs, in {folder}", flush=True)


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
