"""What a JSON file says, held against what it should say; the complaint is one line."""

import json
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import MaxLen

from deformpush.errors import shortened

if TYPE_CHECKING:
    from pydantic import BaseModel

Text = Annotated[str, MaxLen(100_000)]
SHOWN = 60
"""Letters of a value in a message."""


def checked(found: Any, model: "type[BaseModel]", name: str) -> dict[str, Any]:
    """Return what a file holds, as it was found.

    Args:
        found: what the file says.
        model: its keys and their types.
        name: of the file, for the message.

    Raises:
        ValueError: a value is not what it should be; names key, value and what is wanted.
    """
    from pydantic import ValidationError

    if not isinstance(found, dict):
        raise ValueError(f"{name} is damaged: no keys in it")
    try:
        model.model_validate(found)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        wanted = first["msg"][:1].lower() + first["msg"][1:]
        raise ValueError(f"{name} is damaged: {where} = {_show(first['input'])}: {wanted}") from None
    return found


def _show(value: Any) -> str:
    try:
        text = json.dumps(value, default=str)
    except (ValueError, RecursionError):
        text = "..."
    return shortened(text, SHOWN)
