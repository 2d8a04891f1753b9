"""What the command line offers: verbs, config groups, options. Needs no Hydra, so it answers at once."""

from collections.abc import Iterable, Sequence

from deformpush.config.groups import option_groups, suggest
from deformpush.errors import UserError

VERBS = {
    "compare": "put finished runs or a sweep side by side",
    "doctor": "check the simulator against textbook physics",
    "object": "make an object from a picture, a drawing or a list of points",
    "regret": "tell what the best push would have gained at every push of a run",
    "replay": "make the pushes of a run again: identical or not",
    "report": "write one HTML page of a run or a sweep",
    "resume": "continue a run that was killed or stopped",
    "see": "show what is seen in a picture; calibrate a camera",
    "status": "tell which runs of a sweep are done, running, failed",
    "tune": "search settings of the optimizer that need fewer pushes",
    "video": "make an MP4 of a run",
    "view": "open recordings in the viewer, or write a picture of one",
    "whatif": "tell what another push would have done in a run",
}
"""Each verb is the module of that name with `main(argv) -> exit code`, imported when it is asked for."""

FLAGS = {
    **dict.fromkeys(("--help", "-h", "--hydra-help", "--version", "--resolve", "--run", "-r"), False),
    **dict.fromkeys(("--multirun", "-m", "--shell-completion", "-sc"), False),
    **dict.fromkeys(("--cfg", "-c", "--package", "-p", "--config-path", "-cp", "--config-name", "-cn"), True),
    **dict.fromkeys(("--config-dir", "-cd", "--experimental-rerun", "--info", "-i"), True),
}
"""Hydra's flags, and whether a value follows."""

HELP = """\
deformpush: a robot learns in few pushes to bring a soft object on a table to a goal pose

Usage
  python -m deformpush [KEY=VALUE ...]       one run
  python -m deformpush -m KEY=V1,V2 ...      a run for each combination
  python -m deformpush VERB ...              a verb; VERB --help says more

Verbs
{verbs}

Groups: GROUP=OPTION, the default first
{groups}

Settings: seed=N, max_pushes=N, and all that --cfg job shows, for instance acq.w=1.0

Examples
  python -m deformpush object=meat acq.w=2.0 seed=3
  python -m deformpush task.goal.offset=[0.1,-0.15] task.goal.turn_deg=30 hydra.run.dir=runs/mine
  python -m deformpush --config-dir my_conf object=my_slab     with my_conf/object/my_slab.yaml

See also: --cfg job (all settings of this command), --hydra-help (Hydra's own flags), --version
"""


def help_text(argv: Sequence[str] = ()) -> str:
    """Return the help, with the user's own options when `argv` names a --config-dir."""
    groups = _table((group, ", ".join(options)) for group, options in option_groups(argv).items())
    return HELP.format(verbs=_table(VERBS.items()), groups=groups)


def flags_first(argv: Sequence[str]) -> list[str]:
    """Put flags before settings: Hydra's parser does not take settings on both sides of a flag.

    Raises:
        UserError: a flag does not exist, or lacks its value.
    """
    flags: list[str] = []
    settings: list[str] = []
    value_follows = False
    for text in argv:
        name = text.partition("=")[0]
        if value_follows or not text.startswith("-"):
            (flags if value_follows else settings).append(text)
            value_follows = False
        elif name in FLAGS:
            flags.append(text)
            value_follows = FLAGS[name] and name == text
        else:
            known = ", ".join(flag for flag in FLAGS if flag.startswith("--"))
            raise UserError(f"{text}: no such flag{suggest(name, FLAGS)}; flags: {known}")
    if value_follows:
        raise UserError(f"{flags[-1]}: a value must follow")
    return flags + settings


def _table(rows: Iterable[tuple[str, str]]) -> str:
    return "\n".join(f"  {name:<13}{text}" for name, text in rows)
