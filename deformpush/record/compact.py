"""A finished recording made smaller: thousands of one-row chunks become a few large ones."""

import warnings
from collections.abc import Sequence
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader


def compact(parts: Sequence[Path], path: Path, layout: rrb.Blueprint) -> None:
    """Join the parts of a recording in `path`, with the same contents, identity and layout.

    While a run lasts every push is flushed at once, so each number is a chunk with 1.4 kB around it.
    The new file replaces the parts when it is complete.

    Raises:
        OSError, RuntimeError, ValueError: a part cannot be read, or the file not written.
    """
    readers = [reader(part) for part in parts]
    entry = readers[0].recordings()[0]
    temporary = path.with_name(f".{path.name}.tmp")
    try:
        rec = rr.RecordingStream(entry.application_id, recording_id=entry.recording_id, send_properties=False)
        rec.set_sinks(rr.FileSink(temporary), default_blueprint=layout)
        for one in readers:
            rec.send_chunks(one.stream().collect())
        rec.flush()
        rec.disconnect()
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    for part in parts:
        if part != path:
            part.unlink()


def reader(path: Path) -> RrdReader:
    """A recording to read, also that of a run that goes on or was killed."""
    with warnings.catch_warnings():
        # Such a file has no index at its end and is read from front to back.
        warnings.simplefilter("ignore", rr.error_utils.RerunWarning)
        return RrdReader(str(path))


def identity_of(path: Path) -> str | None:
    """The identity by which a viewer knows a recording; None if the file is damaged."""
    try:
        return str(reader(path).recordings()[0].recording_id)
    except (OSError, RuntimeError, ValueError, IndexError):
        return None
