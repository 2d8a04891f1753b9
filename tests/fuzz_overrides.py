"""Tries command lines made from the schema for as long as it is told, and prints every one that goes wrong.

    python -m tests.fuzz_overrides --minutes 30

A run is put up and makes one push; nothing is written. Right is: it works, it fails with a reason, or it is
refused in one line, with exit code 2 and nothing left behind.
"""

import contextlib
import io
import logging
import os
import random
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from contextlib import closing, nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest import mock

from deformpush import __main__
from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import WorldError
from deformpush.experiment.assemble import begin, build_cell, build_optimizer
from deformpush.experiment.setup import Setup
from tests.fuzz_loop import fuzz
from tests.overrides import command_line

LIMIT_S = 10.0
"""Of processor time to put a run up, or to make a push in the toy world; longer is a hang."""


def first_push(setup: Setup, *_: Any) -> SimpleNamespace:
    """Stands for a run: put up as it would be, one push, nothing written."""
    optimizer = build_optimizer(setup)
    cell = build_cell(setup)
    with closing(cell.world):
        episode = begin(setup, cell, optimizer)
        toy = type(cell.world).__name__ == "ToyWorld"
        try:
            with contextlib.nullcontext() if toy else limited(LIMIT_S):
                episode.push()
        except (WorldError, PerceptionError):
            return SimpleNamespace(status="failed")
        except TimeoutError:
            if toy:
                raise
            return SimpleNamespace(status="slow")  # small steps are slow and no mistake
    return SimpleNamespace(status="budget")


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise `TimeoutError` after so much processor time, or ten times as much of any."""

    def late(*_: object) -> None:
        raise TimeoutError(f"longer than {seconds:g} s")

    before = [(sign, signal.signal(sign, late)) for sign in (signal.SIGPROF, signal.SIGALRM)]
    left = signal.setitimer(signal.ITIMER_PROF, seconds)[0]
    left_of_any = signal.setitimer(signal.ITIMER_REAL, 10 * seconds)[0]
    try:
        yield
    finally:
        for sign, handler in before:
            signal.signal(sign, handler)
        signal.setitimer(signal.ITIMER_PROF, left)
        signal.setitimer(signal.ITIMER_REAL, left_of_any)


def tried(argv: list[str], limit_s: float = LIMIT_S) -> tuple[str, str]:
    """What a command line comes to in an empty folder: accepted, failed, refused or wrong; what it says."""
    said, began, home = io.StringIO(), time.process_time(), Path.cwd()
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        stack.enter_context(mock.patch("deformpush.experiment.run.make_run", first_push))
        stack.enter_context(mock.patch("deformpush.experiment.sweep.run_or_resume.make_run", first_push))
        stack.enter_context(mock.patch.dict(os.environ))
        stack.enter_context(mock.patch.object(sys, "argv", ["deformpush", *argv]))
        stack.enter_context(contextlib.redirect_stdout(io.StringIO()))
        stack.enter_context(contextlib.redirect_stderr(said))
        stack.enter_context(mock.patch.object(logging.root, "handlers", list(logging.root.handlers)))
        os.chdir(folder)
        code: Any = None
        try:
            with limited(limit_s):
                __main__.main()
        except SystemExit as leaving:
            code = leaving.code
        except BaseException:
            return "wrong", traceback.format_exc()
        finally:
            os.chdir(home)
        left = [str(path.relative_to(folder)) for path in Path(folder).rglob("*")]
    text, took = said.getvalue(), time.process_time() - began
    if code == 2:
        lines = text.count("\n")
        told = lines >= 1 if "-m" in argv else lines == 1 and not left  # a sweep lists what it refused
        if not told or "Traceback" in text or took > (4 if "-m" in argv else 2):
            return "wrong", f"{lines} lines, {took:.1f} s, left {left}: {text[:2000]}"
        return "refused", text
    if code == 0:
        return "accepted", text
    if code == 1 and "Traceback" not in text:
        return "failed", text
    return "wrong", f"exit code {code}: {text}"


def case(number: int) -> tuple[str, str]:
    """The command line of a number."""
    argv = command_line(random.Random(number))
    became, said = tried(argv)
    return became, f"[{number}] {argv}\n  {said}"


if __name__ == "__main__":
    sys.exit(fuzz(__doc__, nullcontext(case)))
