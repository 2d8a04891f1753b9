"""A finished recording made smaller: thousands of one-row chunks become a few large ones."""

from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader


def compact(path: Path, layout: rrb.Blueprint) -> None:
    """Rewrite a recording that was closed properly, with the same contents, identity and layout.

    While a run lasts every push is flushed at once, so each number is a chunk with 1.4 kB around it.
    The new file replaces the old one when it is complete.
    """
    reader = RrdReader(str(path))
    entry = reader.recordings()[0]
    temporary = path.with_name(f".{path.name}.tmp")
    try:
        rec = rr.RecordingStream(entry.application_id, recording_id=entry.recording_id, send_properties=False)
        rec.set_sinks(rr.FileSink(temporary), default_blueprint=layout)
        rec.send_chunks(reader.stream().collect())
        rec.flush()
        rec.disconnect()
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
