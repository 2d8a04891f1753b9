"""The world of a run that names none: Bullet, or MuJoCo where there is no PyBullet."""

import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.util import find_spec

RESOLVER = "default_world"
"""What conf/config.yaml calls it by."""


def default_world() -> str:
    """The option of the group `world`. PyBullet has a wheel for CPython 3.11 on Linux x86_64 alone."""
    return "bullet" if find_spec("pybullet") else "mujoco"


def register() -> None:
    """Let Hydra resolve it."""
    from omegaconf import OmegaConf

    OmegaConf.register_new_resolver(RESOLVER, default_world, replace=True)


def tell_default(options: Mapping[str, str], overrides: Iterable[str]) -> None:
    """Say, once in a process, that MuJoCo took Bullet's place.

    Args:
        options: the chosen option of every group.
        overrides: what was asked for.
    """
    if options["world"] == default_world() != "bullet" and not any(
        text.lstrip("+").startswith("world=") for text in overrides
    ):
        _tell()


@lru_cache
def _tell() -> None:
    print("world=mujoco: PyBullet, the default, is not installed here; world=... chooses", file=sys.stderr)
