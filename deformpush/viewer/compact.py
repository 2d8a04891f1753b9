"""A finished recording made smaller: thousands of one-row chunks become a few large ones."""

import atexit
import errno
import os
import shutil
import threading
import warnings
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import LazyChunkStream, RrdReader

from deformpush.record.files import replacing

CLOSE_S = 10.0
"""Longest wait for one of Rerun's writers; one that met an error may never answer."""
BATCH = 5_000
"""Chunks that are joined at a time, and so in memory: those of some 180 pushes."""
ROOM_BYTES = 2_000_000
"""Room on the disk below which nothing is handed to Rerun, whose writer tells nobody of a full disk."""


def check_room(folder: Path, needed: int = 0) -> None:
    """Make sure that there is room on the disk.

    Raises:
        OSError: there is not.
    """
    if shutil.disk_usage(folder).free < needed + ROOM_BYTES:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def let_go(rec: rr.RecordingStream) -> None:
    """End a stream; one whose writer does not answer is left behind."""
    ending = threading.Thread(target=rec.disconnect, daemon=True)
    ending.start()
    ending.join(CLOSE_S)
    if ending.is_alive():
        atexit.unregister(rr.rerun_shutdown)  # it would wait for the same writer when the process ends


def compact(parts: Sequence[Path], path: Path, layout: rrb.Blueprint) -> None:
    """Join the parts of a recording in `path`, with the same contents, identity and layout.

    While a run lasts every push is flushed at once, so each number is a chunk with 1.4 kB around it.
    The new file replaces the parts when it is complete.

    Raises:
        OSError, RuntimeError, ValueError: a part cannot be read, or the file not written.
    """
    check_room(path.parent, sum(part.stat().st_size for part in parts))
    readers = [reader(part) for part in parts]
    entry = readers[0].recordings()[0]
    rec = rr.RecordingStream(entry.application_id, recording_id=entry.recording_id, send_properties=False)
    with replacing(path) as temporary:
        try:
            rec.set_sinks(rr.FileSink(temporary), default_blueprint=layout)
            for one in readers:
                chunks = iter(one.stream())
                while batch := list(islice(chunks, BATCH)):
                    rec.send_chunks(LazyChunkStream.from_iter(batch).collect())
                    rec.flush(timeout_sec=CLOSE_S)
        finally:
            let_go(rec)
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
