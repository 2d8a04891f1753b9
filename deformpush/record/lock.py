"""Who works in a run folder: a lock that the system itself takes away from a process that ended."""

import fcntl
import os
from pathlib import Path

from deformpush.record.files import OPENED

LOCK = ".lock"


class Lock:
    """Held from `take` to `release`, or until the process ends, however it ends.

    It is a lock of the kernel (flock) on an empty hidden file, so neither clocks nor process numbers matter.
    """

    def __init__(self, handle: int) -> None:
        self._handle: int | None = handle

    @classmethod
    def take(cls, folder: Path) -> "Lock | None":
        """Take the lock of a folder; None while another process holds it.

        Raises:
            OSError: the folder cannot be written.
        """
        handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | OPENED, 0o644)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            return None
        except OSError:
            os.close(handle)
            raise
        return cls(handle)

    def release(self) -> None:
        """Let others in."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def held(folder: Path) -> bool:
    """Whether a process works in this folder now."""
    try:
        handle = os.open(folder / LOCK, os.O_RDONLY | OPENED)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False  # a file system without locks
    finally:
        os.close(handle)
    return False
