"""Recordings of made-up runs, and what is in a recording, read back: entities, components, values, views."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rerun.chunk import RrdReader

from deformpush.experiment.recorder import Recorder
from deformpush.push_record import PushRecord, RunInfo
from deformpush.record.folder import RunFolder
from deformpush.record.settings import RecordSettings
from tests.record.synthetic import SyntheticRun

TIMELINES = ("push", "sim_time")


@dataclass(frozen=True)
class View:
    """A view of the layout."""

    kind: str
    name: str
    origin: str
    contents: tuple[str, ...]
    properties: dict[str, Any]
    """Keyed by archetype and component, such as `PlotLegend:corner`."""


class Contents:
    """What a recording holds."""

    def __init__(self, path: Path) -> None:
        file = RrdReader(str(path))
        self.entry = file.recordings()[0]
        self._values: dict[tuple[str, str], list[tuple[dict[str, int], Any]]] = defaultdict(list)
        for chunk in file.stream(store=self.entry).to_chunks():
            batch = chunk.to_record_batch()
            at = {name: batch.column(name).cast("int64").to_pylist() for name in _known(batch, TIMELINES)}
            for name in batch.schema.names:
                if ":" in name:
                    for i, value in enumerate(batch.column(name).to_pylist()):
                        if value is not None:
                            times = {timeline: column[i] for timeline, column in at.items()}
                            self._values[str(chunk.entity_path), name].append((times, value))
        self._layout = _layout(file)

    @property
    def entities(self) -> set[str]:
        """Paths of everything logged."""
        return {entity for entity, _ in self._values}

    def fixed(self, entity: str, component: str) -> Any:
        """The one value that stands for all times."""
        (value,) = [value for times, value in self._values[entity, component] if not times]
        return value

    def at(self, entity: str, component: str, timeline: str = "push") -> dict[int, Any]:
        """Values by push, or by nanoseconds of `sim_time`; the last one where there are several."""
        found = [(times[timeline], v) for times, v in self._values[entity, component] if timeline in times]
        return dict(sorted(found, key=lambda pair: pair[0]))

    def times(self, entity: str, timeline: str) -> list[int]:
        """Values of a timeline at which something is logged at an entity, in order, as often as it is."""
        components = [name for path, name in self._values if path == entity]
        each = [[t[timeline] for t, _ in self._values[entity, c] if timeline in t] for c in components]
        return sorted(max(each, key=len, default=[]))

    def curves(self, entity: str) -> np.ndarray:
        """Scalars of an entity `(K, n)`, in the order of the pushes."""
        return np.array(list(self.at(entity, "Scalars:scalars").values()))

    def titles(self, entity: str) -> list[str]:
        """Names of an entity's lines, as its legend shows them."""
        return self.fixed(entity, "SeriesLines:names")

    def colours(self, entity: str, component: str) -> list[tuple[int, int, int]]:
        """Colours of an entity."""
        return [rgb(value) for value in self.fixed(entity, component)]

    @property
    def views(self) -> list[View]:
        """All views of the layout, in the order in which its containers hold them."""
        return [self._view(name) for name in self._below(self._root())]

    def view(self, name: str) -> View:
        """The view of this name."""
        (one,) = [view for view in self.views if view.name == name]
        return one

    def columns(self) -> list[list[str]]:
        """Names of the views in each column of the layout."""
        held = self._layout[self._root()]["ContainerBlueprint:contents"]
        return [[self._view(name).name for name in self._below(f"/{part}")] for part in held]

    def layout(self, entity: str, component: str) -> Any:
        """A value of the layout."""
        return self._layout[entity][component]

    def _root(self) -> str:
        held = {part for one in self._layout.values() for part in one.get("ContainerBlueprint:contents", [])}
        (root,) = [n for n in self._layout if n.startswith("/container/") and n[1:] not in held]
        return root

    def _below(self, name: str) -> list[str]:
        if name.startswith("/view/"):
            return [name]
        parts = self._layout[name]["ContainerBlueprint:contents"]
        return [inner for part in parts for inner in self._below(f"/{part}")]

    def _view(self, name: str) -> View:
        about = self._layout[name]
        within = [values for entity, values in self._layout.items() if entity.startswith(f"{name}/")]
        properties = {key: value for values in within for key, value in values.items()}
        return View(
            about["ViewBlueprint:class_identifier"][0],
            about["ViewBlueprint:display_name"][0],
            about["ViewBlueprint:space_origin"][0],
            tuple(properties.pop("ViewContents:query")),
            properties,
        )


def record(folder: Path, made: SyntheticRun, rows: Sequence[PushRecord] = (), **options: Any) -> Path:
    """Record a made-up run with these settings; the path of its recording."""
    first, *pushes = rows or made.records()
    settings = RecordSettings(**{"figures": False, **options})
    with Recorder(RunFolder.create(folder, ""), settings) as recorder:
        recorder.open(made.info, first, dict)
        for row in pushes:
            recorder(row)
        recorder.close("reached", "all errors")
    return folder / "recording.rrd"


@dataclass(frozen=True)
class Recorded:
    """A run and the contents of its recording."""

    info: RunInfo
    rows: list[PushRecord]
    path: Path
    contents: Contents

    @classmethod
    def make(cls, folder: Path, made: SyntheticRun, **options: Any) -> "Recorded":
        rows = made.records()
        path = record(folder, made, rows, **options)
        return cls(made.info, rows, path, Contents(path))


def rgb(packed: int) -> tuple[int, int, int]:
    """A colour as it is stored."""
    return packed >> 24, packed >> 16 & 255, packed >> 8 & 255


def _known(batch: Any, names: Sequence[str]) -> list[str]:
    return [name for name in names if name in batch.schema.names]


def _layout(file: RrdReader) -> dict[str, dict[str, Any]]:
    """Newest value of every component of the layout, by entity."""
    found: dict[str, dict[str, Any]] = defaultdict(dict)
    for chunk in file.stream(store=file.blueprints()[-1]).to_chunks():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if ":" in name:
                found[str(chunk.entity_path)][name] = batch.column(name).to_pylist()[-1]
    return found
