"""Command lines made from the schema: settings with values that do not belong there, any two groups."""

import json
from collections.abc import Iterator
from functools import cache
from typing import Any

from hypothesis import strategies as st

from deformpush.config.build import OPTIONS, plain
from deformpush.config.compose import compose
from deformpush.config.groups import option_groups

NUMBERS = [0, -1, 1, 2, 1e-300, 1e-12, 1e-6, 1e-3, 0.5, 1e3, 1e9, 1e300, -1e300, 2**63, 10**30, 0.1 + 0.2]
ODD = [
    "nan",
    "inf",
    "-inf",
    "null",
    "true",
    "''",
    "[]",
    "{}",
    "{a:1}",
    "[1,2]",
    "[[1,2],[3]]",
    "'???'",
    "${seed}",
]
UNICODE = ["'é'", "'名前'", "'\u202e'", "'a b'", "'../..'", "'\\''", "'" + "x" * 5000 + "'", "a/b", "1_000"]


def leaves(node: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Full key and value of every setting of a configuration, lists whole."""
    if isinstance(node, dict) and node:
        for name, value in node.items():
            yield from leaves(value, f"{key}.{name}" if key else str(name))
    else:
        yield key, node


@cache
def settings_of(*choices: str) -> dict[str, Any]:
    """The settings of a run with these options, the options themselves aside."""
    return {key: value for key, value in leaves(plain(compose(choices))) if not key.startswith(f"{OPTIONS}.")}


def written(value: Any) -> str:
    """A value as Hydra reads it."""
    return json.dumps(value).replace('"', "'")


def near(value: Any) -> st.SearchStrategy[str]:
    """Values like the one that stands there: other sizes and signs, lists longer and shorter."""
    if isinstance(value, bool) or not isinstance(value, int | float | list):
        return st.sampled_from(ODD)
    if isinstance(value, list):
        items = [*value, *value][: len(value) + 1]
        longer = [value[:-1], items, value[::-1], value + value, value * 300]
        changed = st.tuples(
            st.integers(0, max(0, len(value) - 1)), st.sampled_from([*NUMBERS, "a", None])
        ).map(lambda at: written([*value[: at[0]], at[1], *value[at[0] + 1 :]]))
        return st.sampled_from([written(one) for one in longer]) | changed
    return st.floats(-12, 12).map(lambda power: f"{value * 10**power:g}") | st.floats(-3, 3).map(str)


@st.composite
def one_setting(draw: st.DrawFn, choices: tuple[str, ...] = ()) -> str:
    """One setting with a value that may not belong there."""
    found = settings_of(*choices)
    key = draw(st.sampled_from(sorted(found)))
    value = draw(
        st.one_of(
            st.sampled_from([f"{number!r}" for number in NUMBERS]),
            st.sampled_from(ODD),
            near(found[key]),
            st.sampled_from(UNICODE),
            near(found[key]),
        )
    )
    form = draw(
        st.sampled_from(
            ["{}={}"] * 12 + ["+{}={}", "++{}={}", "~{}", "+{}.new={}", "{}.new={}", "+new.{}={}"]
        )
    )
    return form.format(key, value)


@st.composite
def two_options(draw: st.DrawFn) -> list[str]:
    """Options of two groups, which may not go together."""
    groups = option_groups()
    first, second = draw(st.lists(st.sampled_from(sorted(groups)), min_size=2, max_size=2, unique=True))
    return [f"{group}={draw(st.sampled_from(groups[group]))}" for group in (first, second)]


WORLDS = [("world=toy",)] * 6 + [
    ("world=bullet", "robot=tool"),
    ("world=mujoco", "robot=tool"),
    ("world=bullet",),
]


@st.composite
def command_line(draw: st.DrawFn) -> list[str]:
    """A command line of options and settings."""
    world = draw(st.sampled_from(WORLDS))
    kind = draw(st.sampled_from(["setting", "setting", "setting", "two settings", "options", "both"]))
    options = tuple(draw(two_options())) if kind in ("options", "both") else ()
    taken = {option.partition("=")[0] for option in options}
    world = tuple(option for option in world if option.partition("=")[0] not in taken)
    number = {"setting": 1, "two settings": 2, "options": 0, "both": 1}[kind]
    studies = any(option.startswith("experiment=study") for option in options)
    base = world if studies else (*world, *options)
    return [*world, *options, *(draw(one_setting(base)) for _ in range(number))]
