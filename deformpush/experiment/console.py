"""What a run says on the terminal: a progress bar, and how it ended."""

import shlex
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from types import FrameType
from typing import NoReturn

from deformpush.errors import Stopped
from deformpush.push_record import PushRecord
from deformpush.record.folder import RECORDING
from deformpush.record.summary import Summary, counted
from deformpush.task import TERMS, Errors


class Verbosity(Enum):
    """How much a run says on the terminal."""

    FULL = "a bar, and some lines at the end"
    ONE_LINE = "a bar, and one line at the end: one run of many"
    NO_BAR = "one line at the end: one of many runs that are made at the same time"
    BAR_ONLY = "a bar, and nothing at the end: somebody else tells how it went"
    SILENT = "nothing at all"


class Progress:
    """A bar over the budget of pushes that also shows the errors; silent where no one watches a terminal."""

    def __init__(self, max_pushes: int, verbosity: Verbosity = Verbosity.FULL) -> None:
        from tqdm import tqdm

        silent = verbosity in (Verbosity.NO_BAR, Verbosity.SILENT)
        notebook = "ipykernel" in sys.modules  # it shows the bar, though it is no terminal
        self._bar: tqdm[NoReturn] = tqdm(
            total=max_pushes,
            desc="pushes",
            disable=True if silent else False if notebook else None,
            bar_format="{desc} {n_fmt}/{total_fmt} |{bar:24}| {elapsed}{postfix}",
            leave=verbosity is Verbosity.FULL,
            file=sys.stderr,
        )

    def __call__(self, record: PushRecord) -> None:
        """Show the state after a push."""
        self._bar.n = record.k
        phase = record.action.proposal.phase if record.action else "start"
        self._bar.set_postfix_str(f" {phase}: {_shown(record.errors)}")

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the last state of a single run on the screen, and nothing of one of many."""
        self._bar.close()


@contextmanager
def orderly_end() -> Iterator[None]:
    """Let SIGTERM, by which clusters and systems end a process, end a run as Ctrl-C does: resumable.

    So does SIGHUP, by which a terminal that is closed ends what was begun in it; under nohup it is ignored.

    Where somebody else listens to it already, as a cluster's launcher does, it is left to them. SIGUSR2 tells
    submitit that a job's time is up: the run ends first, then submitit does what it does, which is to queue
    the job again.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    ends = (signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in (*ends, signal.SIGUSR2)}
    then = before[signal.SIGUSR2]
    asked: list[tuple[int, FrameType | None]] = []

    def stop(number: int, frame: FrameType | None) -> None:
        if not asked:
            asked.append((number, frame))
            raise Stopped(f"stopped from outside ({signal.Signals(number).name})")

    ours = [number for number in ends if before[number] is signal.SIG_DFL]
    ours += [signal.SIGUSR2] if callable(then) else []
    for number in ours:
        signal.signal(number, stop)
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, before[number])
        if callable(then) and asked and asked[0][0] == signal.SIGUSR2:
            then(*asked[0])


@contextmanager
def stop_prevails() -> Iterator[None]:
    """Let what was asked to stop end with that stop, also where closing down raised an error over it.

    A signal interrupts any line, also one inside a library whose own clean-up then complains: zipfile of an
    archive left open, for one.

    Raises:
        KeyboardInterrupt: the stop that such an error hides.
    """
    try:
        yield
    except Exception as error:
        behind: BaseException | None = error
        while behind is not None and not isinstance(behind, KeyboardInterrupt):
            behind = behind.__context__
        if behind is None:
            raise
        stop = type(behind)(*behind.args)  # another one: the old one is part of what is behind the error
    else:
        return
    raise stop


def warn(line: str) -> None:
    """Tell people something beside the results."""
    print(line, file=sys.stderr)


def say(summary: Summary, folder: Path, verbosity: Verbosity) -> None:
    """Say how a run ended."""
    if verbosity is Verbosity.FULL:
        print(closing_lines(summary, folder))
    elif verbosity not in (Verbosity.BAR_ONLY, Verbosity.SILENT):
        print(
            f"{folder.name}: {summary.status} after {summary.pushes} pushes, {summary.wall_s:.0f} s",
            flush=True,
        )


def closing_lines(summary: Summary, folder: Path) -> str:
    """The last lines of a run: reached or not, pushes, errors, folder, and how to open the recording."""
    words = {
        "reached": "reached the goal",
        "budget": "did not reach the goal",
        "damaged": "ended the run",
        "failed": "failed",
        "interrupted": "stopped",
    }
    lines = [
        f"{summary.status}: {words[summary.status]} after {counted(summary.pushes)}"
        + ("" if summary.status == "reached" else f" ({summary.reason})"),
        f"errors:    {_shown(Errors(summary.errors))}",
        f"time:      {summary.wall_s:.0f} s, of which {summary.step_s:.0f} s in the simulator",
        f"folder:    {folder}",
    ]
    if summary.calibration is not None:
        lines.insert(2, f"forecasts: {summary.calibration:.0%} of outcomes inside their 95% intervals")
    if summary.strain_peak is not None:
        lines.insert(2, f"strain:    {_strain(summary)}")
    if summary.force_peak is not None:
        limit = "no limit is given" if summary.force_limit is None else f"limit {summary.force_limit:.3g} N"
        lines.insert(3, f"force:     {summary.force_peak:.2g} N at most, of the tool ({limit})")
    recording = folder / RECORDING
    if recording.exists():
        lines.append(f"recording: rerun {shlex.quote(str(recording))}")
    return "\n".join(lines)


def _strain(summary: Summary) -> str:
    assert summary.strain_peak is not None, "asked of a world that measures it"
    peak = f"{summary.strain_peak:.1%} at most"
    if summary.strain_limit is None:
        return f"{peak} (p99 of the volume; no limit is given)"
    limit = f"the limit of {100 * summary.strain_limit:.3g}%"
    return f"{peak} (p99 of the volume), {summary.exceedances} of {summary.pushes} pushes beyond {limit}"


def _shown(errors: Errors) -> str:
    """The sizes of the errors (1)-(3), in their units."""
    return ", ".join(f"{term.name} {term.show(errors.size(term))}" for term in TERMS)
