"""The extras of this package: what brings a library that only some users need."""

import importlib
from typing import Any

from deformpush.errors import UserError

EXTRAS = {"joblib": "sweep", "submitit": "sweep", "ray": "ray"}
"""Extra of this package by the plugin that a launcher needs."""


def needed_extra(name: str) -> str | None:
    """The extra that brings the plugin of a launcher option or module; None for Hydra's own."""
    return next((extra for plugin, extra in EXTRAS.items() if plugin in name), None)


def not_installed(choice: str, extra: str) -> str:
    """The line for a launcher whose plugin is missing."""
    return f"hydra/launcher={choice}: needs pip install 'deformpush[{extra}]'"


def library(name: str, extra: str = "rivals", asks: str = "optimizer") -> Any:
    """Import a library that only a rival, or another that `asks` for it, needs.

    Raises:
        UserError: it is not installed; the message says what to install.
    """
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name and error.name.split(".")[0] != name.split(".")[0]:
            raise
        package = name.split(".")[0]
        raise UserError(
            f"{asks}: {package} is not installed; pip install 'deformpush[{extra}]' brings it"
        ) from None
