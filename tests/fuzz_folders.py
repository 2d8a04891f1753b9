"""Harms run folders as a stranger could, reads them with every verb, and prints what goes wrong.

    python -m tests.fuzz_folders --minutes 30

Right is: exit code 0, 1 or 2, no traceback, a few seconds at most, no module imported that the folder names,
and nothing written but where it was asked for.
"""

import contextlib
import io
import os
import random
import shutil
import sys
import tempfile
import traceback
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import deformpush
from deformpush import __main__
from deformpush.experiment.run import make_run
from deformpush.experiment.sweep import manifest
from deformpush.experiment.sweep.manifest import Job
from tests.damage import damage
from tests.fuzz_loop import Case, fuzz
from tests.fuzz_overrides import limited
from tests.setups import setup

LIMIT_S = 5.0
"""Of processor time; longer is a hang."""
CANARY = "canary_of_a_stranger"
"""Name of a module that lies beside the run; nobody may import it."""
READERS = {
    "status": ["status", "SWEEP"],
    "compare": ["compare", "SWEEP", "--out", "OUT"],
    "compare run": ["compare", "RUN", "GOOD", "--out", "OUT"],
    "report": ["report", "RUN", "--out", "OUT/report.html"],
    "report sweep": ["report", "SWEEP", "--out", "OUT/report.html"],
    "replay": ["replay", "RUN"],
    "resume": ["resume", "RUN"],
    "view": ["view", "RUN"],
    "tables": [],
}
"""By name: the command line, or none for the Python API."""


def make_sweep(folder: Path) -> Path:
    """A sweep of two small runs, one of which was stopped."""
    toy = ["world=toy", "robot=tool", "record=light", "record.figures=false", "optimizer=abo_motion"]
    for name, seed in (("good", 0), ("run", 1)):
        make_run(setup(*toy, "max_pushes=5", f"seed={seed}"), folder / name)
    manifest.write(folder, [Job("good", ["seed=0"]), Job("run", ["seed=1"])])
    (folder / "run" / f"{CANARY}.py").write_text("class Canary: pass\n")
    shutil.copytree(folder / "run", folder / "stopped")
    for name in ("summary.json", "checkpoint.npz"):
        (folder / "stopped" / name).unlink()
    return folder


def content(folder: Path) -> dict[str, object]:
    """Every file of a folder, by name: a link by its target, a small file by its bytes."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        stat = path.lstat()
        small = path.is_file() and not path.is_symlink() and stat.st_size < 10_000_000
        found[str(path.relative_to(folder))] = (
            stat.st_mode,
            stat.st_size,
            path.read_bytes() if small else None,
        )
    return found


def tried(sweep: Path, rng: random.Random) -> tuple[str, str, str]:
    """Harm one run of a copy of a sweep and read it; what was done, whether that is right, what was said."""
    with tempfile.TemporaryDirectory() as scratch:
        home = Path(scratch)
        (home / "outside").mkdir()
        (home / "outside" / "mine").write_text("mine")
        (home / "out").mkdir()
        whole = Path(shutil.copytree(sweep, home / "sweep"))
        run = whole / rng.choice(["run", "run", "stopped"])
        done = damage(run if rng.random() < 0.9 else whole, rng, home / "outside" / "mine", CANARY)
        reader = rng.choice(sorted(READERS))
        places = {"SWEEP": str(whole), "RUN": str(run), "GOOD": str(whole / "good"), "OUT": str(home / "out")}
        argv = [places.get(word, word.replace("OUT", places["OUT"])) for word in READERS[reader]]
        before = content(home)
        code, said = answer(argv, run, home)
        after = content(home)
        allowed = ("out/", "sweep/sweep.csv", f"sweep/{run.name}/" if reader == "resume" else "out/")
        changed = [
            name
            for name in {**before, **after}
            if before.get(name) != after.get(name)
            and not name.startswith(allowed)
            and name not in ("out", "sweep")
        ]
        changed = [name for name in changed if not (reader == "resume" and name == f"sweep/{run.name}")]
        wrong = code not in (0, 1, 2) or "Traceback" in said or CANARY in sys.modules or bool(changed)
        sys.modules.pop(CANARY, None)
        return f"{reader} after {done}", "wrong" if wrong else str(code), f"{code} {changed} {said}"


def answer(argv: list[str], run: Path, home: Path) -> tuple[object, str]:
    """Exit code and stderr of a command line, or of the Python API."""
    said, was = io.StringIO(), Path.cwd()
    with contextlib.ExitStack() as stack:
        stack.enter_context(mock.patch("deformpush.cli.view._window", return_value=0))
        stack.enter_context(mock.patch.dict(os.environ))
        stack.enter_context(mock.patch.object(sys, "argv", ["deformpush", *argv]))
        stack.enter_context(contextlib.redirect_stdout(io.StringIO()))
        stack.enter_context(contextlib.redirect_stderr(said))
        os.chdir(home)
        try:
            with limited(LIMIT_S):
                if argv:
                    __main__.main()
                else:
                    tables(run)
        except SystemExit as leaving:
            return leaving.code, said.getvalue()
        except BaseException:
            return "raised", said.getvalue() + traceback.format_exc()
        finally:
            os.chdir(was)
    return 0, said.getvalue()


def tables(run: Path) -> None:
    """Read a run as frames."""
    with contextlib.suppress(deformpush.UserError):
        read = deformpush.load(run)
        assert isinstance(read, deformpush.Run)
        for name in ("pushes", "config", "summary"):
            getattr(read, name)
        repr(read), read._repr_html_()
        try:
            _ = read.contours
        except (OSError, ValueError) as error:
            if "contours.npz" not in str(error) or "\n" in str(error):
                raise


@contextlib.contextmanager
def cases() -> Iterator[Case]:
    """Folders of one sweep, each harmed by its number."""
    with tempfile.TemporaryDirectory() as scratch:
        sweep = make_sweep(Path(scratch) / "sweep")

        def case(number: int) -> tuple[str, str]:
            done, became, said = tried(sweep, random.Random(number))
            return became, f"seed {number}: {done}\n  {said}"

        yield case


if __name__ == "__main__":
    sys.exit(fuzz(__doc__, cases()))
