"""config.yaml read back: settings in plain YAML, and nothing that could do more than be read.

Whatever else YAML has is refused with the number of its line: aliases and anchors (a few lines of them may
stand for gigabytes), tags, merge keys, keys that stand twice, interpolations (`${...}` would be looked up on
the reader's machine). Sizes are limited. Numbers are read as OmegaConf reads them, which wrote the file.
"""

import re
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from deformpush.errors import shortened
from deformpush.record.files import JSON_BYTES, read_bytes

DEEPEST, MOST = 20, 20_000
"""Mappings and lists in each other, and values in all."""
SHARED = 10_000
"""Letters of a part of a text that is kept for the next text which has it too."""
SHOWN = 60
"""Letters of a key or value in a message."""
PART = re.compile(r"^\S.*\n?(?:^(?:[ \t].*)?\n?)*", re.MULTILINE)
"""A line that is not indented, with the indented ones below it."""
WHOLE = re.compile(r"[-+]?\d+(_\d+)*[eE][-+]?\d+$")
"""A float that PyYAML would take for a text: without a dot."""
NO_TAGS = ("tag:yaml.org,2002:timestamp", "tag:yaml.org,2002:merge", "tag:yaml.org,2002:value")
"""What plain text may look like and is not read as."""


class SavedConfigError(ValueError):
    """The text is no saved configuration; the message is one line, without the name of the file."""


def read_text(path: Path) -> str:
    """The text of a config.yaml.

    Raises:
        OSError: it cannot be read, is a link, no regular file, or larger than 1 MB.
        SavedConfigError: it is no text.
    """
    try:
        return read_bytes(path, JSON_BYTES).decode()
    except UnicodeDecodeError as error:
        raise SavedConfigError(f"no text ({error.reason} at byte {error.start})") from None


def read_config(path: Path) -> dict[str, Any]:
    """The settings in a config.yaml: mappings, lists, text, numbers, true, false and null.

    Raises:
        OSError: as `read_text`.
        SavedConfigError: it holds anything else.
    """
    return read_settings(read_text(path))


def read_settings(text: str) -> dict[str, Any]:
    """What a text says, read part by part: the runs of a sweep have most parts in common.

    Those who ask share what they get, so nobody may change it.

    Raises:
        SavedConfigError: it is no mapping of settings.
    """
    found: dict[str, Any] = {}
    texts = PART.findall(text)
    if not texts or "".join(texts) != text or not all(map(_begins_with_a_key, texts)):
        texts = [text]
    line = 0
    for part in texts:
        values = _shared(part) if len(part) <= SHARED else _parsed(part)
        if isinstance(values, SavedConfigError):
            raise SavedConfigError(_moved(str(values), line))
        if twice := values.keys() & found.keys():
            raise SavedConfigError(f"line {line + 1}: {_show(min(twice))} stands twice")
        found |= values
        line += part.count("\n")
    return found


def _begins_with_a_key(part: str) -> bool:
    return re.match(r"[A-Za-z_][\w.-]*:(\s|$)", part) is not None


def _moved(message: str, lines: int) -> str:
    """A message about a part as one about the whole, in which it begins some lines later."""
    return re.sub(r"^line (\d+)", lambda found: f"line {int(found[1]) + lines}", message)


@lru_cache(maxsize=4096)
def _shared(text: str) -> dict[str, Any] | SavedConfigError:
    return _parsed(text)


def _parsed(text: str) -> dict[str, Any] | SavedConfigError:
    """What a YAML text says, or why it is refused."""
    from yaml import MarkedYAMLError, YAMLError

    try:
        found = _Reader(text).document()
    except SavedConfigError as error:
        return error
    except MarkedYAMLError as error:
        where = error.problem_mark or error.context_mark
        return SavedConfigError(f"line {where.line + 1 if where else '?'}: {_line(error.problem or error)}")
    except (YAMLError, ValueError) as error:
        return SavedConfigError(_line(error))
    return found if isinstance(found, dict) else SavedConfigError("no mapping of settings")


class _Reader:
    """Builds values from the events of a parser, which makes none of its own."""

    def __init__(self, text: str) -> None:
        import yaml

        self._yaml, self._parser, self._left = yaml, _loader()(text), MOST

    def document(self) -> Any:
        """The one value of the text."""
        yaml = self._yaml
        self._next()
        if isinstance(self._next(), yaml.StreamEndEvent):
            return None
        found = self._value(self._next(), 0)
        self._next()
        if not isinstance(event := self._next(), yaml.StreamEndEvent):
            raise _refused(event, "another document")
        return found

    def _next(self) -> Any:
        return self._parser.get_event()

    def _value(self, event: Any, depth: int) -> Any:
        yaml = self._yaml
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) is not None:
            raise _refused(event, "an alias or anchor")
        if getattr(event, "tag", None) is not None:
            raise _refused(event, f"the tag {_show(event.tag)}")
        self._left -= 1
        if self._left < 0:
            raise _refused(event, f"more than {MOST} values")
        if depth > DEEPEST:
            raise _refused(event, f"more than {DEEPEST} levels")
        if isinstance(event, yaml.ScalarEvent):
            return self._scalar(event)
        if isinstance(event, yaml.SequenceStartEvent):
            items = []
            while not isinstance(item := self._next(), yaml.SequenceEndEvent):
                items.append(self._value(item, depth + 1))
            return items
        values: dict[str, Any] = {}
        while not isinstance(name := self._next(), yaml.MappingEndEvent):
            key = self._value(name, depth + 1) if isinstance(name, yaml.ScalarEvent) else None
            if not isinstance(key, str) or key == "<<":
                raise _refused(name, "a key that is no name")
            if key in values:
                raise SavedConfigError(f"line {name.start_mark.line + 1}: {_show(key)} stands twice")
            values[key] = self._value(self._next(), depth + 1)
        return values

    def _scalar(self, event: Any) -> Any:
        if "${" in event.value:
            raise _refused(event, f"the interpolation {_show(event.value)}")
        tag = self._parser.resolve(self._yaml.ScalarNode, event.value, event.implicit)
        return self._parser.construct_object(self._yaml.ScalarNode(tag, event.value, event.start_mark))


@cache
def _loader() -> Any:
    """A parser that takes plain text for numbers as OmegaConf does; the one in C is ten times as fast."""
    import yaml

    class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
        """Its own lists of what plain text may be."""

    Loader.yaml_implicit_resolvers = {
        letter: [(tag, text) for tag, text in known if tag not in NO_TAGS]
        for letter, known in Loader.yaml_implicit_resolvers.items()
    }
    for letter in "-+0123456789":
        Loader.yaml_implicit_resolvers.setdefault(letter, []).append(("tag:yaml.org,2002:float", WHOLE))
    return Loader


def _refused(event: Any, what: str) -> SavedConfigError:
    return SavedConfigError(f"line {event.start_mark.line + 1}: {what}; a run writes none")


def _show(text: object) -> str:
    return shortened(repr(text)[1:-1], SHOWN)


def _line(error: object) -> str:
    return " ".join(str(error).split())[: 2 * SHOWN]
