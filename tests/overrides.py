"""Command lines made from the schema: settings with values that do not belong there, any two groups."""

import json
import random
from collections.abc import Iterator
from functools import cache
from typing import Any

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


WORLDS = [
    *[("world=toy",)] * 10,
    ("world=bullet", "robot=tool"),
    ("world=mujoco", "robot=tool"),
    ("world=bullet",),
]


@cache
def settings_of(*choices: str) -> dict[str, Any]:
    """The settings of a run with these options, the options themselves aside."""
    return {key: value for key, value in leaves(plain(compose(choices))) if not key.startswith(f"{OPTIONS}.")}


def written(value: Any) -> str:
    """A value as Hydra reads it."""
    return json.dumps(value).replace('"', "'")


def near(value: Any, rng: random.Random) -> str:
    """A value like the one that stands there: of another size or sign, a list longer or shorter."""
    if isinstance(value, list):
        at = rng.randrange(len(value) + 1)
        odd = rng.choice([*NUMBERS, "a", None])
        changed = [
            value[:-1],
            [*value, *value],
            value[::-1],
            value * 300,
            [*value[:at], odd, *value[at + 1 :]],
        ]
        return written(rng.choice(changed))
    if isinstance(value, bool) or not isinstance(value, int | float):
        return rng.choice(ODD)
    if isinstance(value, int):
        return str(round(value * 10 ** rng.uniform(-2, 8)) * rng.choice([1, 1, -1]))
    return f"{rng.choice([value, value, -value]) * 10 ** rng.uniform(-12, 12):g}"


def setting(rng: random.Random, choices: tuple[str, ...]) -> str:
    """One setting of a run with these options, with a value that may not belong there."""
    found = settings_of(*choices)
    keys = sorted(found)
    key = rng.choice(keys)
    while key.endswith("_target_") and rng.random() < 0.9:
        key = rng.choice(keys)
    value = rng.choice(
        [repr(rng.choice(NUMBERS)), rng.choice(ODD), rng.choice(UNICODE), *[near(found[key], rng)] * 4]
    )
    odd = ["+{}={}", "++{}={}", "~{}", "+{}.new={}", "{}.new={}", "+new.{}={}"]
    return rng.choice(["{}={}"] * 20 + odd).format(key, value)


def command_line(rng: random.Random) -> list[str]:
    """A command line of options and settings."""
    groups = option_groups()
    options = []
    if rng.random() < 0.5:
        options = [f"{group}={rng.choice(groups[group])}" for group in rng.sample(sorted(groups), 2)]
    taken = {option.partition("=")[0] for option in options}
    world = [option for option in rng.choice(WORLDS) if option.partition("=")[0] not in taken]
    studies = any(option.startswith("experiment=study") for option in options)
    base = tuple(world) if studies else (*world, *options)
    number = rng.choice([1, 1, 2, 3] if not options else [0, 1])
    many = ["-m", f"seed=1,{rng.choice(['2', '-1', 'x'])}"] if rng.random() < 0.05 else []
    return [*many, *world, *options, *(setting(rng, base) for _ in range(number))]
