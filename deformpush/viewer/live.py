"""Viewers that watch a run live. A viewer that is not there must not delay or break the run."""

import logging
import re
import socket
import subprocess
from pathlib import Path
from time import monotonic, sleep

from deformpush.record.settings import ADDRESS, SPAWNED

STARTUP_S = 10.0
"""How long a viewer that was just started may take to listen."""
ANSWER_S = 2.0
WINDOWS: list["subprocess.Popen[bytes]"] = []
"""Viewers that were started: they outlive the runs they show."""

log = logging.getLogger(__name__)


def viewers(spawn: bool, connect: str | None) -> list[str]:
    """Addresses of the viewers to stream to; one that does not answer is left out with a warning."""
    found = []
    if spawn:
        if not _answers(SPAWNED):
            WINDOWS.append(_window())
        found += _answering("record.spawn=true", SPAWNED, STARTUP_S, *WINDOWS[-1:])
    if connect:
        found += _answering(f"record.connect={connect}", connect, ANSWER_S)
    return found


def program() -> Path:
    """The viewer that came with the SDK, also where its folder is not on the PATH."""
    import rerun_cli

    return Path(rerun_cli.__file__).with_name("rerun")


def _window() -> "subprocess.Popen[bytes]":
    """A viewer on this machine that stays when the run has ended, and does not hear its Ctrl-C."""
    port = SPAWNED.rpartition(":")[2].partition("/")[0]
    command = [str(program()), "--port", port, "--bind", "127.0.0.1", "--hide-welcome-screen"]
    quiet = subprocess.DEVNULL
    return subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True)


def _answering(
    key: str, address: str, patience_s: float, window: "subprocess.Popen[bytes] | None" = None
) -> list[str]:
    """The address, or nothing when the time is over, or the window that was opened there is gone."""
    deadline = monotonic() + patience_s
    while not _answers(address):
        if monotonic() > deadline or (window is not None and window.poll() is not None):
            log.warning("%s: no viewer answers; the run goes on without one", key)
            return []
        sleep(0.1)
    return [address]


def _answers(address: str) -> bool:
    match = re.fullmatch(ADDRESS, address)
    assert match is not None, "the settings check addresses"
    try:
        socket.create_connection((match["host"], int(match["port"])), timeout=ANSWER_S).close()
    except OSError:
        return False
    return True
