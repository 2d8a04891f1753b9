"""Libraries of the extra `rivals`."""

import importlib
from typing import Any

from deformpush.errors import UserError


def library(name: str) -> Any:
    """Import a library that only a rival needs.

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
            f"optimizer: {package} is not installed; pip install 'deformpush[rivals]' brings it"
        ) from None
