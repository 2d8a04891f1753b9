"""Which settings tell runs apart, and which runs differ in their seed alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from deformpush.record.finished import FinishedRun

SEED = "seed"
PLACE = {"acquisition": "acq", "stop": "task.stop"}
"""Where the settings of a config group stand, if not under its name."""
WITHOUT_EFFECT = ("record",)
"""Groups that change what is written of a run, not the run."""


@dataclass(frozen=True)
class Variant:
    """Runs with the same settings but for the seed."""

    label: str
    runs: tuple[FinishedRun, ...]

    @property
    def reached(self) -> int:
        """Runs that reached the goal."""
        return sum(run.summary.status == "reached" for run in self.runs)

    @property
    def unharmed(self) -> int | None:
        """Runs that reached the goal and never strained the object beyond its limit; None without a limit."""
        ends = [run.summary for run in self.runs]
        if any(end.exceedances is None for end in ends):
            return None
        return sum(end.status == "reached" and not end.exceedances for end in ends)


class Configured(Protocol):
    """What has settings: a run, or the defaults."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """Values by full key."""

    @property
    def options(self) -> Mapping[str, str]:
        """The chosen option of every config group."""


def differing(runs: Sequence[Configured]) -> dict[str, list[Any]]:
    """Settings that are not the same in all runs: full key -> value in each run, None where it has none.

    The chosen option of a group stands under the group's name. What follows from it is left out: settings of
    the group that only change with its option, and settings elsewhere that repeat one of those.
    """
    groups = _changing([run.options for run in runs])
    found = _changing([run.settings for run in runs])
    groups = {key: values for key, values in groups.items() if key not in WITHOUT_EFFECT}
    found = {key: values for key, values in found.items() if key.partition(".")[0] not in WITHOUT_EFFECT}
    follows: dict[str, list[Any]] = {}
    for group, options in groups.items():
        inside = PLACE.get(group, group) + "."
        follows |= {
            key: values
            for key, values in found.items()
            if key.startswith(inside) and _function_of(options, values)
        }
    own = {
        key: values
        for key, values in found.items()
        if key not in follows and not any(_repeats(values, other) for other in follows.values())
    }
    return groups | dict(sorted(own.items(), key=lambda item: (item[0] == SEED, item[0])))


def variants(runs: Sequence[FinishedRun], difference: dict[str, list[Any]]) -> list[Variant]:
    """Group runs by the settings they differ in, the seed aside, in the order of their first run."""
    columns = {key: [show(v) for v in values] for key, values in difference.items() if key != SEED}
    members: dict[tuple[str, ...], list[int]] = {}
    for i in range(len(runs)):
        members.setdefault(tuple(values[i] for values in columns.values()), []).append(i)
    telling = _telling(columns)
    made = []
    for those in members.values():
        label = ", ".join(f"{key} {columns[key][those[0]]}" for key in telling)
        made.append(Variant(label or runs[those[0]].title.rpartition(", ")[0], tuple(runs[i] for i in those)))
    return made


def titles(runs: Sequence[FinishedRun], difference: dict[str, list[Any]]) -> list[str]:
    """A short name for each run: the settings that tell it from the others, or its folder's name."""
    columns = {key: [show(v) for v in values] for key, values in difference.items()}
    telling = _telling(columns)
    named = [", ".join(f"{key} {columns[key][i]}" for key in telling) for i in range(len(runs))]
    apart = len(set(named)) == len(runs) > 1
    return named if apart else [run.name for run in runs]


def _telling(columns: dict[str, list[str]]) -> list[str]:
    """The first keys that tell as many variants apart as all keys do."""
    kept: list[str] = []
    apart = 1
    for key in columns:
        count = len(set(zip(*(columns[name] for name in [*kept, key]), strict=True)))
        if count > apart:
            kept, apart = [*kept, key], count
    return kept


def show(value: Any) -> str:
    """A setting as people write it."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple):
        return "[" + ",".join(map(show, value)) + "]"
    return str(value)


def _changing(each: Sequence[Any]) -> dict[str, list[Any]]:
    keys = {key: None for one in each for key in one}
    columns = {key: [one.get(key) for one in each] for key in keys}
    return {key: values for key, values in columns.items() if any(v != values[0] for v in values[1:])}


def _function_of(options: Sequence[Any], values: Sequence[Any]) -> bool:
    """Whether runs of the same option always have the same value."""
    seen: dict[Any, Any] = {}
    return all(seen.setdefault(option, value) == value for option, value in zip(options, values, strict=True))


def _repeats(values: Sequence[Any], others: Sequence[Any]) -> bool:
    """Whether the values are those of another setting, wherever there is one."""
    return all(value is None or value == other for value, other in zip(values, others, strict=True))
