"""Type hints as the schema of a setting: check a value against one, and say in words what it allows."""

import json
import math
import types
import typing
from typing import Annotated, Any, Literal, Union

from deformpush.errors import UserError, shortened

WORDS = {float: "a number", int: "a whole number", bool: "true or false", str: "text", type(None): "null"}


class ConfigError(UserError):
    """A setting is unknown, missing, of the wrong type or out of its range."""


def validate(value: Any, hint: Any, key: str) -> Any:
    """Return `value` as `hint` asks for it: lists become tuples, a whole number may stand for a float.

    Nothing else is converted, and nan and infinity are never values. Hints that pydantic cannot check
    (arrays, protocols) allow anything else.

    Raises:
        ConfigError: Names the key, the value and what is allowed.
    """
    from pydantic import PydanticSchemaGenerationError, TypeAdapter, ValidationError

    try:
        if not _finite(value):
            raise ConfigError(f"{key} = {value}: must be {describe(hint)}, and finite")
        # JSON is what pydantic reads strictly and yet takes a list for a tuple.
        return TypeAdapter(hint).validate_json(json.dumps(value), strict=True)
    except PydanticSchemaGenerationError:
        return value
    except ValidationError:
        raise ConfigError(f"{key} = {show(value)}: must be {describe(hint)}") from None


def _finite(value: Any) -> bool:
    """Whether all numbers in a value of plain lists and mappings are finite."""
    if isinstance(value, dict):
        return all(_finite(item) for item in value.values())
    if isinstance(value, list | tuple):
        return all(_finite(item) for item in value)
    return not isinstance(value, float) or math.isfinite(value)


def describe(hint: Any) -> str:
    """Say what a hint allows: 'a number above 0 or null', '[a number, a number]'."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if hint in WORDS:
        return WORDS[hint]
    if origin is Annotated:
        return " ".join(filter(None, (describe(args[0]), _range(args[1:]), _length(args[1:]))))
    if origin is Literal:
        return " or ".join(str(choice) for choice in args)
    if origin in (Union, types.UnionType):
        return " or ".join(describe(choice) for choice in args)
    if origin is tuple and args[-1] is not Ellipsis:
        return f"[{', '.join(describe(item) for item in args)}]"
    if origin in (tuple, list):
        return f"a list, each item {describe(args[0])}"
    return "a group of settings" if origin is dict or hint is dict else getattr(hint, "__name__", str(hint))


def show(value: Any) -> str:
    """Write a value as YAML would, cut to fit a line."""
    return shortened(json.dumps(value, default=str), 80)


def _bounds(metadata: tuple[Any, ...], name: str) -> Any:
    """Return the first bound of this name (gt, ge, lt, le, min_length, max_length) in the metadata."""
    return next((b for m in metadata if (b := getattr(m, name, None)) is not None), None)


def _range(metadata: tuple[Any, ...]) -> str:
    gt, ge, lt, le = (_bounds(metadata, name) for name in ("gt", "ge", "lt", "le"))
    low, high = ge if gt is None else gt, le if lt is None else lt
    if low is not None and high is not None:
        return f"in {'[' if gt is None else '('}{low:g}, {high:g}{']' if lt is None else ')'}"
    if low is not None:
        return f"above {low:g}" if ge is None else f"of {low:g} or more"
    if high is not None:
        return f"below {high:g}" if le is None else f"of {high:g} or less"
    return ""


def _length(metadata: tuple[Any, ...]) -> str:
    least, most = _bounds(metadata, "min_length"), _bounds(metadata, "max_length")
    parts = ([f"at least {least}"] if least else []) + ([f"at most {most}"] if most else [])
    return f"({' and '.join(parts)} of them)" if parts else ""
