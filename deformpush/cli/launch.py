"""Between the command line and a run: Hydra composes one, or with -m many, and they are made."""

import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from deformpush.cli import usage
from deformpush.config import default_world
from deformpush.config.build import OPTIONS
from deformpush.config.groups import check_choices, conf_dir
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.sweep import names

if TYPE_CHECKING:
    from omegaconf import DictConfig


LONGEST = 20_000
"""Letters of an argument: Hydra takes a second to read so many."""


def launch(argv: list[str]) -> int:
    """Compose what the command line says and make the run, or with -m the runs; return the worst exit code.

    Raises:
        UserError: a flag, a setting or the folder will not do.
        TroubleError: the workers of a sweep die again and again.
    """
    if long := [text for text in argv if len(text) > LONGEST]:
        raise UserError(
            f"{long[0][:40]}...: has {len(long[0])} letters, {LONGEST} are allowed; "
            "write it in a YAML file of a folder that --config-dir names"
        )
    sys.argv[1:] = usage.flags_first(names.with_folder(argv))
    _check_flags(sys.argv[1:])
    check_choices(sys.argv[1:])
    # Composition errors then arrive here as exceptions with their cause, instead of as text and an exit.
    os.environ["HYDRA_FULL_ERROR"] = "1"
    from omegaconf import OmegaConf

    from deformpush.experiment.sweep.hydra_callback import absent, begun, leave_nothing

    begun.clear()
    absent.clear()
    OmegaConf.register_new_resolver("run_name", names.short, replace=True)
    default_world.register()
    # conf/hydra/launcher/ray.yaml has the name of the plugin's own option; Hydra then compares the two.
    warnings.filterwarnings("ignore", message="\\n'hydra/launcher/ray' is validated")
    codes: list[int] = []
    try:
        with _in_our_words(argv, codes):
            _persistently(_job(codes))
    except KeyboardInterrupt:
        if begun:
            _sweep_ended(begun[-1], codes)
        raise
    except UserError:
        leave_nothing()
        raise
    if begun:
        return _sweep_ended(begun[-1], codes)
    if (code := max(codes, default=0)) == UserError.exit_code:
        leave_nothing()
    return code


def _job(codes: list[int]) -> Callable[[], None]:
    """What Hydra is given to do; it appends the exit code of each run it makes in this process."""
    import hydra
    from hydra.core.hydra_config import HydraConfig
    from hydra.types import RunMode

    @hydra.main(version_base="1.3", config_path=str(conf_dir()), config_name="config")
    def job(cfg: "DictConfig") -> None:
        codes.append(1)
        try:
            codes[-1] = _run(cfg)
        except UserError as error:
            # Said here, so that one bad combination of a sweep does not stop the others.
            print(error.line, file=sys.stderr)
            codes[-1] = error.exit_code
        except Exception:
            if HydraConfig.get().mode is not RunMode.MULTIRUN:
                raise
            traceback.print_exc()  # the run's summary.json says `failed`; the other runs go on

    return job


def _persistently(job: Callable[[], None], tries: int = 3) -> None:
    """Do a job whose workers may die; what they had begun is continued by the next.

    Raises:
        TroubleError: they died each time.
    """
    for left in reversed(range(tries)):
        try:
            return job()
        except BrokenProcessPool as error:
            if not left:
                raise TroubleError(f"the sweep ends: its workers die again and again ({error})") from error
            print("a worker process died (out of memory?); going on with what is left", file=sys.stderr)
    return None


@contextmanager
def _in_our_words(argv: list[str], codes: list[int]) -> Iterator[None]:
    """Make one line of what Hydra and YAML raise, and of a run folder that cannot be made."""
    from hydra.errors import HydraException
    from yaml import MarkedYAMLError

    from deformpush.experiment.sweep.hydra_callback import CannotBeginError

    try:
        yield
    except CannotBeginError as stop:
        raise stop.error from stop
    except HydraException as error:
        from deformpush.config.compose import explain

        raise UserError(explain(error, argv)) from error
    except MarkedYAMLError as error:
        from deformpush.config.compose import not_yaml

        raise UserError(not_yaml(error)) from error
    except (OSError, ValueError) as error:
        if codes or isinstance(error, UserError):
            raise
        name, why = getattr(error, "filename", None), getattr(error, "strerror", None) or error
        raise UserError(
            f"hydra.run.dir = {name}: cannot be used as run folder: {why}" if name else why
        ) from error


def _sweep_ended(folder: Path, codes: "list[int]") -> int:
    """Say what became of a sweep; its exit code, from the `codes` of the runs made here if there are any."""
    from deformpush.cli.status import tell
    from deformpush.experiment.sweep.status import look

    overview = look(folder)
    print(tell(overview))
    if codes:
        return max(codes)
    left = overview.counts
    return 2 if left["refused"] else int(left["failed"] + left["interrupted"] + left["pending"] > 0)


def _run(cfg: "DictConfig") -> int:
    """Make the run that Hydra composed and return its exit code.

    The chosen options of the config groups join the configuration as plain values: Hydra keeps them outside
    of it, and the configuration saved with the run must be whole.
    """
    from hydra.core.hydra_config import HydraConfig
    from hydra.types import RunMode
    from omegaconf import open_dict
    from omegaconf.errors import OmegaConfBaseException

    from deformpush.cli.exit_code import exit_code
    from deformpush.config.compose import refuse_study
    from deformpush.config.locate import trust
    from deformpush.config.schema import validate
    from deformpush.experiment.console import Verbosity
    from deformpush.experiment.run import make_run
    from deformpush.experiment.setup import read

    hydra = HydraConfig.get()
    runtime, many = hydra.runtime, hydra.mode is RunMode.MULTIRUN
    folder = Path(runtime.output_dir)
    # A user's own classes may lie beside the user's own YAML files.
    for source in runtime.config_sources:
        if source.provider == "command-line":
            trust(Path(source.path))
    try:
        with open_dict(cfg):
            cfg[OPTIONS] = {group: option for group, option in runtime.choices.items() if "/" not in group}
            retry = validate(cfg.pop("sweep").get("retry"), bool, "sweep.retry")
        if not many:
            refuse_study(runtime.choices, hydra.sweeper.get("params") or ())
            return exit_code(make_run(read(cfg), folder))
        from deformpush.experiment.sweep.run_or_resume import run_or_resume

        alone = hydra.launcher._target_.endswith("BasicLauncher")
        verbosity = Verbosity.ONE_LINE if alone else Verbosity.NO_BAR
        return exit_code(run_or_resume(cfg, folder, retry, verbosity))
    except OmegaConfBaseException as error:
        raise UserError(f"{error.full_key}: {str(error).splitlines()[0]}") from error


def _check_flags(argv: list[str]) -> None:
    """Let Hydra's parser look at the flags first: by itself it would print its whole usage.

    Raises:
        UserError: a flag has a wrong value.
    """
    from hydra._internal.utils import get_args_parser

    def refuse(message: str) -> NoReturn:
        raise UserError(message)

    parser = get_args_parser()
    parser.error = refuse  # type: ignore[method-assign]
    parser.parse_args(argv)
