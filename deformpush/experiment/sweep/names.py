"""Names of sweep and run folders: their overrides, so that the same command finds what it made before."""

import re
import zlib
from collections.abc import Sequence

LONGEST = 150
"""Of a folder's name; file systems allow 255 bytes, and temporary files add to it."""
FLAGS = ("-m", "--multirun")
NOT_IN_NAMES = ("hydra.", "hydra/", "sweep.")
"""Settings of how runs are made, not of what they are."""


def with_folder(argv: Sequence[str]) -> list[str]:
    """The command line of a sweep with the folder it goes to, if it does not name one itself."""
    if not set(FLAGS) & set(argv) or any(text.startswith("hydra.sweep.dir=") for text in argv):
        return list(argv)
    settings = [text for text in argv if "=" in text and not text.startswith("-")]
    name = sweep_name([text for text in settings if not text.lstrip("+~").startswith(NOT_IN_NAMES)])
    return [*argv, f"hydra.sweep.dir='runs/sweeps/{name}'"]


def sweep_name(overrides: Sequence[str]) -> str:
    """A folder name for a sweep over these settings, whatever their order."""
    text = "_".join(sorted(overrides)).replace(",", "+")
    return short(re.sub(r"[()\[\]'\" ]", "", text))


def short(text: str) -> str:
    """A text as the name of a folder: without signs of shell and path, and cut with a checksum if long.

    Different texts get different names, but for texts that differ in such signs alone.
    """
    name = re.sub(r"[^\w=.,+\-()\[\]]", "_", text, flags=re.ASCII).strip(".")
    if len(name) > LONGEST:
        name = f"{name[: LONGEST - 9]}-{zlib.crc32(text.encode()):08x}"
    return name or "default"
