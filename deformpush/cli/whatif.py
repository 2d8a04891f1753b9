"""The verb `whatif`: what another push would have done at a place of a run, beside what was done."""

import argparse
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from deformpush.cli import own_classes
from deformpush.errors import UserError

if TYPE_CHECKING:
    from deformpush.experiment.branch import Branch
    from deformpush.push_record import PushRecord

KEYS = ("kappa", "d", "speed")
COMPARISON = "compare.rrd"


def main(argv: Sequence[str]) -> int:
    """Make another push from a state of a run; exit code 0 when it was made.

    Raises:
        UserError: there is no such run, push or state, or the other push is none.
        TroubleError: the robot cannot make the other push, or the recorded one does not repeat itself.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush whatif",
        description="Tell what another push K would have done: from the state after push K - 1, which the "
        "world has saved, beside what push K did.",
        epilog="example: python -m deformpush whatif runs/mine --push 17 kappa=0.6 d=0.02 --into runs/other",
    )
    parser.add_argument("run", help="run folder")
    parser.add_argument("--push", type=int, required=True, metavar="K", help="the push that is another one")
    parser.add_argument("values", nargs="*", metavar="KEY=VALUE", help=f"{', '.join(KEYS)}; else as it was")
    parser.add_argument(
        "--into", metavar="FOLDER", help=f"record the run up to the other push there, and {COMPARISON}"
    )
    own_classes.add(parser)
    given = parser.parse_intermixed_args(argv)
    values = _values(given.values)
    own_classes.use(given)
    from deformpush.experiment.branch import Branch
    from deformpush.experiment.run import existing
    from deformpush.record.folder import RunFolder

    if given.into is not None:
        RunFolder.create(given.into, "")
    with closing(Branch(existing(given.run), given.push)) as branch:
        before = branch.run.proposal(branch.k)
        kappa, d = (float(values.get(name, value)) for name, value in zip(KEYS, before.u, strict=False))
        other = branch.push(kappa, d, values.get("speed", before.speed))
        print(text(branch, other))
        if given.into is not None:
            _record(branch, other, Path(given.into))
    return 0


def text(branch: "Branch", other: "PushRecord") -> str:
    """What both pushes did, in a few lines."""
    from deformpush.study.beside import rows
    from deformpush.study.tables import terminal

    by = other.errors.e_T - branch.made.errors.e_T
    than = "as large" if not by else f"{abs(by):.4f} {'larger' if by > 0 else 'smaller'}"
    lines = [f"push {other.k} of {branch.run.folder.path}, from the state after push {other.k - 1}"]
    told = terminal(rows(branch.before, branch.made, other))
    return "\n".join([*lines, told, f"e_T would have been {than}"])


def _values(texts: Sequence[str]) -> dict[str, float]:
    """The other push, as far as it is told.

    Raises:
        UserError: a key is unknown, or a value no number.
    """
    found: dict[str, float] = {}
    for one in texts:
        key, _, value = one.partition("=")
        if key not in KEYS:
            raise UserError(f"{one}: a push has kappa=, d= (m) and speed= (m/s)")
        try:
            found[key] = float(value)
        except ValueError:
            raise UserError(f"{key} = {value}: must be a number") from None
    if not found:
        raise UserError("kappa=, d= or speed= must say what the other push is")
    return found


def _record(branch: "Branch", other: "PushRecord", into: Path) -> None:
    """Write the run with the other push, and both side by side."""
    from deformpush.experiment import branch_folder
    from deformpush.record.files import replacing
    from deformpush.study import beside
    from deformpush.study.tables import markdown

    folder = branch_folder.write(branch, other, into)
    told = markdown(beside.rows(branch.before, branch.made, other))
    about = f"**Push {other.k} of {branch.run.folder.path}**\n\n{told}"
    with replacing(into / COMPARISON) as made:
        beside.write(made, [("as it was made", branch.run.folder), ("what if", folder)], about)
    print(f"written: {into}, with the pushes up to {other.k}; rerun {into / COMPARISON} shows both")
