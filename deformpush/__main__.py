"""Entry: `python -m deformpush VERB ...` for a verb, `python -m deformpush KEY=VALUE ...` for a run."""

import os
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from deformpush import __version__
from deformpush.errors import UserError

if TYPE_CHECKING:
    from hydra.errors import HydraException
    from omegaconf import DictConfig

VERBS = {"doctor": "check the simulator against textbook physics"}
"""Each verb is the module of that name with `main(argv) -> exit code`, imported when it is asked for."""


def main() -> None:
    """Run the command line and exit: 0 done, 1 a run failed, 2 bad input, 130 interrupted."""
    argv = sys.argv[1:]
    try:
        sys.exit(_dispatch(argv))
    except UserError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)


def _dispatch(argv: list[str]) -> int:
    """Send a verb to its module and everything else to Hydra."""
    if argv[:1] == ["--version"]:
        print(f"deformpush {__version__}")
        return 0
    if argv and argv[0].isidentifier():
        if argv[0] not in VERBS:
            from deformpush.config import suggest

            raise UserError(
                f"{argv[0]}: neither a verb nor KEY=VALUE{suggest(argv[0], VERBS)}; verbs: {', '.join(VERBS)}"
            )
        return int(import_module(f"deformpush.{argv[0]}").main(argv[1:]))
    return _hydra(argv)


def _hydra(argv: list[str]) -> int:
    """Compose the configuration and make the run, or with -m the runs."""
    # Composition errors then arrive here as exceptions with their cause, instead of as text and an exit.
    os.environ.setdefault("HYDRA_FULL_ERROR", "1")
    import hydra
    from hydra.errors import HydraException

    from deformpush.config import conf_dir

    codes = [0]

    @hydra.main(version_base="1.3", config_path=str(conf_dir()), config_name="config")
    def job(cfg: "DictConfig") -> int:
        codes.append(run(cfg))
        return codes[-1]

    try:
        job()
    except HydraException as error:
        from deformpush.composition import explain

        raise UserError(explain(error, argv)) from error
    return max(codes)


def run(cfg: "DictConfig") -> int:
    """Make the run that Hydra composed and return its exit code.

    The chosen options of the config groups join the configuration as plain values: Hydra keeps them outside of it,
    and the configuration saved with the run must be whole.
    """
    from hydra.core.hydra_config import HydraConfig
    from omegaconf import open_dict

    from deformpush.assemble import execute
    from deformpush.config import OPTIONS, check

    runtime = HydraConfig.get().runtime
    folder = Path(runtime.output_dir)
    try:
        with open_dict(cfg):
            cfg[OPTIONS] = {group: option for group, option in runtime.choices.items() if "/" not in group}
        check(cfg)
        return execute(cfg, folder)
    except UserError:
        _discard(folder)
        raise


def _discard(folder: Path) -> None:
    """Remove the folder that Hydra made for a run that never began. One that holds anything stays."""
    try:
        folder.rmdir()
        folder.parent.rmdir()
    except OSError:
        pass


if __name__ == "__main__":
    main()
