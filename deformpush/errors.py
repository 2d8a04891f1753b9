"""Errors that are told in one line, without a traceback, and what keeps the line short."""

from typing import ClassVar


def shortened(text: str, most: int) -> str:
    """A text that fits into a message: at most so many letters, `...` at its end where some are left out."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


class UserError(ValueError):
    """Says in one line which key or file is wrong, and what is allowed: the user's to put right."""

    exit_code: ClassVar[int] = 2

    @property
    def line(self) -> str:
        """The message, in one line also where it repeats something of several."""
        return " ".join(str(self).split("\n"))


class TroubleError(UserError):
    """Says in one line what went wrong around a run: a full disk, a world that does not repeat itself."""

    exit_code: ClassVar[int] = 1


class Stopped(KeyboardInterrupt):
    """Asked to end from outside, as a cluster does when the time is up (SIGTERM)."""
