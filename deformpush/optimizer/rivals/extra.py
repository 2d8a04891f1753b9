"""Libraries of the extras `rivals` and `tune`."""

import importlib
from typing import Any

from deformpush.errors import UserError


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
