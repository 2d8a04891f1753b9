"""What the command line prints on: a terminal, a pipe that may close, a disk that may be full."""

import os
import sys
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

KEPT = {"\n", "\t", "\r"}
"""Control characters that are printed; a carriage return moves a progress bar."""


class Output:
    """Stands for standard output or error: prints what can be read, and ends no run because nobody listens.

    Names and reasons may come from a stranger's files. Their control characters could move the cursor, change
    the title or paste text in a terminal, so none of them reaches it.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.problem: OSError | None = None
        """Why something could not be written; None while all was, or when the reader went away."""
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a terminal that knows ASCII alone

    def write(self, text: str) -> int:
        """Print text without its control characters."""
        try:
            self._stream.write(printable(text))
            self._stream.flush()
        except BrokenPipeError:  # as in `status | head -1`
            self._give_up()
        except OSError as error:
            self.problem = error
            self._give_up()
        return len(text)

    def flush(self) -> None:
        """All is written already."""

    def _give_up(self) -> None:
        """Let everything from now on go nowhere, also what Python itself prints at the end."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def printable(text: str) -> str:
    """Text with its control characters replaced by a question mark in a box."""
    if text.isprintable():
        return text
    return "".join(
        "\ufffd" if unicodedata.category(c) in ("Cc", "Cf", "Cs") and c not in KEPT else c for c in text
    )


@contextmanager
def readable_output() -> Iterator[Output]:
    """Put `Output` in the place of both standard streams; gives that of standard output."""
    before = sys.stdout, sys.stderr
    # A stream that was closed before the start is None.
    out, err = (Output(stream or open(os.devnull, "w")) for stream in before)  # noqa: SIM115
    sys.stdout, sys.stderr = out, err
    try:
        yield out
    finally:
        sys.stdout, sys.stderr = before
