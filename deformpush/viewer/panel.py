"""What every part of the recording is told, and when: two timelines, and what happens on them."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr

from deformpush.cell.world import Moment
from deformpush.push_record import Action, PushRecord, RunInfo

PUSH = "push"
"""Counts states."""
SIM_TIME = "sim_time"
"""Simulated time, which goes on inside a push."""

Times = Mapping[str, Sequence[float] | np.ndarray]
"""Values by timeline: counts for `push`, seconds for `sim_time`."""


class Panel:
    """A part of the recording. The stream sets the time, the panel logs its entities."""

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log what never changes."""

    def decide(self, rec: rr.RecordingStream, action: Action) -> None:
        """Log the push that was chosen, at the state it was chosen in (k - 1)."""

    def move(self, rec: rr.RecordingStream, motion: Sequence[Moment], began_s: float) -> None:
        """Log the moments inside a push, on `sim_time` alone."""

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log the state after push k, at k."""


def set_time(rec: rr.RecordingStream, push: int, sim_time_s: float) -> None:
    """Let what is logged from now on stand at this state and time."""
    rec.set_time(PUSH, sequence=push)
    rec.set_time(SIM_TIME, duration=sim_time_s)


def columns(times: Times) -> list[rr.TimeColumn]:
    """Time columns for a batch of rows."""
    counts = {name: np.asarray(at, np.int64) for name, at in times.items() if name == PUSH}
    seconds = {name: at for name, at in times.items() if name != PUSH}
    return [rr.TimeColumn(name, sequence=at) for name, at in counts.items()] + [
        rr.TimeColumn(name, duration=at) for name, at in seconds.items()
    ]
