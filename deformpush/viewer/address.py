"""Viewers: what an address of one looks like, and the program that is one."""

from pathlib import Path

ADDRESS = r"rerun(\+https?)?://(?P<host>[^/:]+):(?P<port>\d{1,5})/proxy"
SPAWNED = "rerun+http://127.0.0.1:9876/proxy"
"""Where a viewer started on this machine listens."""


def program() -> Path:
    """The viewer that came with the SDK, also where its folder is not on the PATH."""
    import rerun_cli

    return Path(rerun_cli.__file__).with_name("rerun")
