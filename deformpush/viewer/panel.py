"""What every part of the recording is told, and when."""

from typing import Protocol

import rerun as rr

from deformpush.push_record import Decision, PushRecord, RunInfo


class Panel(Protocol):
    """A part of the recording. The stream sets the time, the panel logs its entities."""

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log what never changes."""

    def decide(self, rec: rr.RecordingStream, decision: Decision) -> None:
        """Log the push that was chosen, at the state it was chosen in (k - 1)."""

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log the state after push k, at k."""
