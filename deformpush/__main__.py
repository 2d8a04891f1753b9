"""Entry: `python -m deformpush VERB ...` for a verb, `python -m deformpush KEY=VALUE ...` for a run."""

import os
import sys

if __name__ == "__main__":
    # `python -m` puts the working directory on the path, ahead of all else. It may be a stranger's folder: no
    # numpy.py in it is to be imported, here or by the workers of a sweep.
    here, home = os.path.realpath(os.curdir), os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    if here != home:
        sys.path[:] = [entry for entry in sys.path if os.path.realpath(entry) != here]
        os.environ["PYTHONSAFEPATH"] = "1"

from importlib import import_module

from deformpush import __version__
from deformpush.cli import usage
from deformpush.cli.terminal import readable_output
from deformpush.config.groups import option_groups, suggest
from deformpush.errors import UserError


def main() -> None:
    """Run the command line and exit: 0 done, 1 a run failed, 2 bad input, 130 interrupted."""
    # Before numpy loads: sums over several threads differ in their last bits, and a run must repeat exactly.
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
    # What Rerun's writers say of a full disk is said here, in one line.
    os.environ.setdefault("RUST_LOG", "warn,re_log_encoding=off,re_sdk=off")
    with readable_output() as out:
        try:
            code = _dispatch(sys.argv[1:])
        except UserError as error:
            print(error.line, file=sys.stderr)
            code = error.exit_code
        except KeyboardInterrupt as stop:
            print(str(stop) or "interrupted", file=sys.stderr)
            code = 130
        if out.problem is not None:
            print(f"standard output: cannot be written ({out.problem.strerror})", file=sys.stderr)
    sys.exit(code or int(out.problem is not None))


def _dispatch(argv: list[str]) -> int:
    """Send a verb to its module, answer a question, and give everything else to Hydra."""
    verb = argv[0] if argv and argv[0].isidentifier() else None
    if verb in usage.VERBS:
        return int(import_module(f"deformpush.cli.{verb}").main(argv[1:]))
    if verb is not None and verb not in option_groups(argv):
        verbs = ", ".join(usage.VERBS)
        raise UserError(f"{verb}: neither a verb nor KEY=VALUE{suggest(verb, usage.VERBS)}; verbs: {verbs}")
    for text in argv:
        if text in usage.VERBS and text not in option_groups(argv):
            raise UserError(f"{text}: a verb must be the first argument")
        if text.startswith("="):
            raise UserError(f"{text}: not KEY=VALUE, the key is missing")
    if {"--help", "-h"} & set(argv):
        print(usage.help_text(argv), end="")
        return 0
    if "--version" in argv:
        print(f"deformpush {__version__}")
        return 0
    from deformpush.cli.launch import launch

    return launch(argv)


if __name__ == "__main__":
    main()
