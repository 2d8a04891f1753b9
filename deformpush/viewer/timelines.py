"""The two timelines of a recording: `push` counts states, `sim_time` is simulated time."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr

PUSH = "push"
SIM_TIME = "sim_time"

Times = Mapping[str, Sequence[float] | np.ndarray]
"""Values by timeline: counts for `push`, seconds for `sim_time`."""


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
