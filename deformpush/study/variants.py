"""Which settings tell runs apart, which runs differ in their seed alone, and what those did push by push."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, zip_longest
from typing import Protocol

import numpy as np

from deformpush.record import palette
from deformpush.record.finished import FinishedRun
from deformpush.task import Quantity

Array = np.ndarray
Differences = dict[str, list[object]]
"""Full key of a setting -> its value in each run, None where a run has no such setting."""

SEED = "seed"
PLACE = {"acquisition": "acq", "stop": "task.stop"}
"""Where the settings of a config group stand, if not under its name."""
WITHOUT_EFFECT = ("record",)
"""Groups that change what is written of a run, not the run."""
MOST = len(palette.RUNS)
"""Variants drawn in one figure: more lines no one follows."""
QUARTILES = (0.25, 0.5, 0.75)
BAND_CAPTION = "line: median over seeds, band: their middle half; a run that has ended keeps its last error"
"""What figures with bands say of them."""


@dataclass(frozen=True)
class Band:
    """Quartiles of an error after push 0, 1, ... of the longest run; each `(K+1,)`, in its unit."""

    low: Array
    middle: Array
    high: Array


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
        """Runs that reached the goal and kept to the object's limits; None where one has none."""
        ends = [run.summary for run in self.runs]
        if any(end.exceedances is None for end in ends):
            return None
        return sum(end.status == "reached" and not end.exceedances for end in ends)

    def arrived(self, last: int) -> Array:
        """Share of the runs that had reached the goal after push 0, ..., `last`."""
        ends = np.array([run.summary.pushes for run in self.runs if run.summary.status == "reached"])
        return np.array([(ends <= k).sum() for k in range(last + 1)]) / len(self.runs)

    def band(self, quantity: Quantity) -> Band:
        """Quartiles of an error over the runs; a run that has ended counts with its last value.

        Otherwise the band would tell only of the runs that still go on, which are the ones that do badly.
        """
        curves = lengthened([run.error(quantity) for run in self.runs])
        return Band(*np.quantile(curves, QUARTILES, axis=0))


class Configured(Protocol):
    """What has settings: a run, or the defaults."""

    @property
    def settings(self) -> Mapping[str, object]:
        """Values by full key."""

    @property
    def options(self) -> Mapping[str, str]:
        """The chosen option of every config group."""


def lengthened(curves: Sequence[Array]) -> Array:
    """Curves `(n_i,)` as rows `(len(curves), max n_i)`, each going on with its last value."""
    longest = max(len(curve) for curve in curves)
    return np.stack([np.pad(curve, (0, longest - len(curve)), mode="edge") for curve in curves])


def differing(runs: Sequence[Configured]) -> Differences:
    """Settings that are not the same in all runs.

    The chosen option of a group stands under the group's name. What follows from it is left out: settings of
    the group that only change with its option, and settings elsewhere that repeat one of those.
    """
    groups = _changing([run.options for run in runs])
    found = _changing([run.settings for run in runs])
    groups = {key: values for key, values in groups.items() if key not in WITHOUT_EFFECT}
    found = {key: values for key, values in found.items() if key.partition(".")[0] not in WITHOUT_EFFECT}
    follows: Differences = {}
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


def variants(runs: Sequence[FinishedRun], differences: Differences) -> list[Variant]:
    """Group runs by the settings they differ in, the seed aside, in the order of their first run."""
    columns = {key: [show(v) for v in values] for key, values in differences.items() if key != SEED}
    members: dict[tuple[str, ...], list[int]] = {}
    for i in range(len(runs)):
        members.setdefault(tuple(values[i] for values in columns.values()), []).append(i)
    needed = _needed(columns)
    made = []
    for those in members.values():
        label = ", ".join(f"{key} {columns[key][those[0]]}" for key in needed)
        made.append(Variant(label or runs[those[0]].title.rpartition(", ")[0], tuple(runs[i] for i in those)))
    return made


def titles(runs: Sequence[FinishedRun], differences: Differences) -> dict[str, str]:
    """A short title by name of the run: the settings that tell it from the others, or its folder's name."""
    columns = {key: [show(v) for v in values] for key, values in differences.items()}
    needed = _needed(columns)
    made = [", ".join(f"{key} {columns[key][i]}" for key in needed) for i in range(len(runs))]
    names = [run.name for run in runs]
    return dict(zip(names, made if len(set(made)) == len(runs) > 1 else names, strict=True))


def best(groups: Sequence[Variant]) -> list[Variant]:
    """At most `MOST` variants: all, or those that reached the goal most often, then soonest."""
    if len(groups) <= MOST:
        return list(groups)

    def rank(one: Variant) -> tuple[float, float]:
        pushes = [run.summary.pushes for run in one.runs]
        return -one.reached / len(one.runs), float(np.median(pushes))

    return sorted(groups, key=rank)[:MOST]


def in_turn(groups: Sequence[Variant]) -> list[FinishedRun]:
    """The first run of each variant, then the second of each, and so on."""
    return [run for run in chain(*zip_longest(*(one.runs for one in groups))) if run is not None]


def stop_values(runs: Sequence[FinishedRun], quantity: Quantity) -> list[float]:
    """The different stop values of an error, in its unit."""
    return sorted({value for run in runs if np.isfinite(value := run.stop(quantity))})


def show(value: object) -> str:
    """A setting as people write it."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple):
        return "[" + ",".join(map(show, value)) + "]"
    return str(value)


def _needed(columns: dict[str, list[str]]) -> list[str]:
    """The first keys that tell as many runs apart as all keys do."""
    kept: list[str] = []
    apart = 1
    for key in columns:
        count = len(set(zip(*(columns[name] for name in [*kept, key]), strict=True)))
        if count > apart:
            kept, apart = [*kept, key], count
    return kept


def _changing(each: Sequence[Mapping[str, object]]) -> Differences:
    keys = {key: None for one in each for key in one}
    columns = {key: [one.get(key) for one in each] for key in keys}
    return {key: values for key, values in columns.items() if any(v != values[0] for v in values[1:])}


def _function_of(options: Sequence[object], values: Sequence[object]) -> bool:
    """Whether runs of the same option always have the same value."""
    seen: dict[object, object] = {}
    return all(seen.setdefault(option, value) == value for option, value in zip(options, values, strict=True))


def _repeats(values: Sequence[object], others: Sequence[object]) -> bool:
    """Whether the values are those of another setting, wherever there is one."""
    return all(value is None or value == other for value, other in zip(values, others, strict=True))
