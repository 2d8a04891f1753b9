"""Turns a composed configuration into checked components.

A component is any class named by `_target_`. Its constructor's arguments are its settings, and their type
hints, with `annotated_types` ranges, are the schema. Every complaint is one line that starts with the key.
"""

import dataclasses
import inspect
import types
import typing
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any

from annotated_types import Ge
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from deformpush.config.groups import suggest
from deformpush.config.locate import PACKAGE, locate
from deformpush.config.schema import ConfigError, show, validate
from deformpush.errors import UserError

OPTIONS = "options"
"""Top-level key that keeps the chosen option of every config group: `{object: rect, ...}`."""
PLAIN: dict[str, Any] = {"seed": Annotated[int, Ge(0)], "max_pushes": Annotated[int, Ge(1)]}
"""Top-level keys that are plain values; all others are groups of settings."""


def build(node: Any, key: str | None = None, **runtime: Any) -> Any:
    """Build the component that `node` describes, and first those nested in it.

    Args:
        node: A mapping with `_target_: package.module.Class` and that class's settings.
        key: Full key of the node, for messages; a DictConfig knows its own.
        **runtime: Objects for arguments that the YAML does not name (a generator, a camera).

    Raises:
        ConfigError: A key is unknown or missing, a value has the wrong type or range, or two values disagree.
    """
    return component(node, key, tuple(runtime))(**runtime)


def component(
    node: Any,
    key: str | None = None,
    runtime: Collection[str] = (),
    kind: Any = None,
    whole: bool = False,
) -> Callable[..., Any]:
    """Check the component that `node` describes, and leave its last arguments to whoever has them.

    Args:
        node: see `build`.
        key: see `build`.
        runtime: names of the arguments that will be given when it is called.
        kind: what it must be: a class, a protocol, or several; None: anything.
        whole: whether a class of deformpush must be given every setting, also one that has a default.

    Returns:
        Makes the component, and raises `ConfigError` where its constructor finds that two values disagree.

    Raises:
        ConfigError: as `build`.
    """
    if isinstance(node, DictConfig):
        key = node._get_full_key("") if key is None else key
        node = plain(node)
    return _component(node, key or "", runtime, kind, whole)


def plain(cfg: DictConfig) -> dict[str, Any]:
    """Return the configuration as plain dicts and lists, interpolations resolved.

    Raises:
        ConfigError: An interpolation names nothing.
    """
    try:
        return typing.cast("dict[str, Any]", OmegaConf.to_container(cfg, resolve=True))
    except OmegaConfBaseException as error:
        raise ConfigError(f"{error.full_key}: {str(error).splitlines()[0]}") from error


def check(values: Mapping[str, Any]) -> None:
    """Check the top level: plain values by type and range, everything else a group of settings.

    Raises:
        ConfigError: For the first value that does not fit.
    """
    for key, value in values.items():
        if key in PLAIN:
            validate(value, PLAIN[key], key)
        elif not isinstance(value, Mapping):
            group = next((name for name in values.get(OPTIONS) or {} if name.startswith(key)), key)
            hint = f"set {key}.NAME=VALUE, or choose an option with {group}=OPTION"
            raise ConfigError(f"{key} = {show(value)}: must stay a group of settings; {hint}")


def dump(values: Mapping[str, Any]) -> str:
    """Write a plain configuration as YAML text, which `deformpush.record.saved_config` reads."""
    return OmegaConf.to_yaml(OmegaConf.create(dict(values)))


def _component(
    node: Any, key: str, runtime: Collection[str] = (), kind: Any = None, whole: bool = False
) -> Callable[..., Any]:
    """What makes the component of `node`, which is of this kind; a dataclass need not be named."""
    if not isinstance(node, Mapping):
        raise ConfigError(f"{key} = {show(node)}: must be a group of settings")
    settings = {str(name): value for name, value in node.items() if name != "_target_"}
    kinds = _kinds(kind)
    target = node.get("_target_", next((cls for cls in kinds if dataclasses.is_dataclass(cls)), None))
    if target is None:
        raise ConfigError(f"{key}._target_: missing; it names the class to build")
    cls = target if isinstance(target, type) else locate(target, _join(key, "_target_"))
    if kinds and not any(_fits(cls, one) for one in kinds):
        allowed = " or ".join(one.__name__ for one in kinds)
        article = "an" if allowed[0] in "AEIOU" else "a"
        raise ConfigError(f"{key}._target_ = {target}: must be {article} {allowed}")
    hints, required, open_ended = _schema(cls)
    known = [name for name in hints if name not in runtime]
    for name in settings:
        if name not in known and not open_ended:
            has = f"{key or cls.__name__} has: {', '.join(known) or 'no settings'}"
            raise ConfigError(f"{_join(key, name)}: unknown{suggest(name, known)}; {has}")
    foreign = not cls.__module__.startswith(f"{PACKAGE}.")
    for name in known if whole and not foreign and not open_ended else required:
        if settings.get(name, "???") == "???" and name not in runtime:
            raise ConfigError(f"{_join(key, name)}: missing; {cls.__name__} needs it")
    values = {
        name: _value(value, hints.get(name, Any), _join(key, name), foreign, whole)
        for name, value in settings.items()
    }

    def make(**given: Any) -> Any:
        try:
            return cls(**values, **given)
        except UserError:
            raise
        except ValueError as error:
            raise ConfigError(_join(key, str(error))) from error

    return make


def _value(value: Any, hint: Any, key: str, anything: bool, whole: bool) -> Any:
    """Check one setting; what has a `_target_`, or stands where a dataclass is asked for, is built.

    Where the hint does not say of what kind a component must be, there may be one only if `anything` goes:
    in a class of the user's own.
    """
    if isinstance(value, Mapping):
        kinds = _kinds(hint)
        if "_target_" in value and not kinds and not anything:
            raise ConfigError(f"{key}._target_ = {value['_target_']}: no component belongs here")
        if "_target_" in value or any(map(dataclasses.is_dataclass, kinds)):
            return _component(value, key, kind=hint, whole=whole)()
    elif isinstance(value, list) and any(isinstance(item, Mapping) and "_target_" in item for item in value):
        item_hint = (*typing.get_args(hint), Any)[0]
        return tuple(_value(item, item_hint, f"{key}[{i}]", anything, whole) for i, item in enumerate(value))
    return validate(value, hint, key)


def _fits(cls: type, kind: type) -> bool:
    """Whether a class is of this kind, or has all that a protocol asks for."""
    if not getattr(kind, "_is_protocol", False):
        return issubclass(cls, kind)
    asked = {
        name
        for base in kind.__mro__
        if base not in (object, typing.Protocol, typing.Generic)
        for name in (*vars(base), *getattr(base, "__annotations__", {}))
        if not name.startswith("_")
    }
    fields = {name for base in cls.__mro__ for name in getattr(base, "__annotations__", {})}
    return all(hasattr(cls, name) or name in fields for name in asked)


def _schema(cls: type) -> tuple[dict[str, Any], list[str], bool]:
    """Return the hints of the arguments of `cls`, those without a default, and whether it takes any name."""
    try:
        parameters = list(inspect.signature(cls).parameters.values())
    except ValueError:  # a class written in C may not tell
        return {}, [], True
    source = cls if dataclasses.is_dataclass(cls) else vars(cls).get("__init__", cls)
    try:
        known = typing.get_type_hints(source, include_extras=True)
    except NameError:  # hints a user's class imports for type checkers only
        known = {}
    named = [p for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    hints = {p.name: known.get(p.name, Any) for p in named}
    return (
        hints,
        [p.name for p in named if p.default is p.empty],
        any(p.kind is p.VAR_KEYWORD for p in parameters),
    )


def _kinds(hint: Any) -> list[type]:
    """The classes and protocols that a hint allows a component to be; none when it does not say."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is Annotated:
        return _kinds(args[0])
    if origin in (typing.Union, types.UnionType):
        return [cls for part in args for cls in _kinds(part)]
    plain = (bool, int, float, str, tuple, list, dict, object, type(None))
    return [hint] if isinstance(hint, type) and hint not in plain and hint is not Any else []


def _join(key: str, name: str) -> str:
    return f"{key}.{name}" if key else name
