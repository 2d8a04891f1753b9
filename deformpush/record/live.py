"""Viewers that watch a run live. A viewer that is not there must not delay or break the run."""

import logging
import re
import socket
from time import monotonic, sleep

import rerun as rr

from deformpush.record.address import ADDRESS, SPAWNED

STARTUP_S = 5.0
"""How long a viewer that was just started may still take to listen, after the five seconds Rerun gives it."""
ANSWER_S = 2.0

log = logging.getLogger(__name__)


def viewers(rec: rr.RecordingStream, spawn: bool, connect: str | None) -> list[str]:
    """Addresses of the viewers to stream to; one that does not answer is left out with a warning."""
    found = []
    if spawn:
        rec.spawn(connect=False, hide_welcome_screen=True)
        found += _answering("record.spawn=true", SPAWNED, STARTUP_S)
    if connect:
        found += _answering(f"record.connect={connect}", connect, ANSWER_S)
    return found


def _answering(key: str, address: str, patience_s: float) -> list[str]:
    match = re.fullmatch(ADDRESS, address)
    assert match is not None, "the recorder checks addresses"
    deadline = monotonic() + patience_s
    while True:
        try:
            socket.create_connection((match["host"], int(match["port"])), timeout=ANSWER_S).close()
        except OSError:
            if monotonic() > deadline:
                log.warning("%s: no viewer answers; the run goes on without one", key)
                return []
            sleep(0.1)
        else:
            return [address]
