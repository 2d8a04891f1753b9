"""The Python API: make a run, read runs back as frames and figures. `import deformpush` offers it."""

import json
import threading
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from html import escape
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np

from deformpush.config import compose as config
from deformpush.config.locate import use_config_dir
from deformpush.errors import UserError
from deformpush.experiment.branch import Branch
from deformpush.experiment.console import Verbosity
from deformpush.experiment.one_thread import one_thread
from deformpush.experiment.run import make_run
from deformpush.experiment.setup import Setup, read
from deformpush.experiment.sweep import manifest
from deformpush.experiment.sweep.names import NOT_IN_NAMES
from deformpush.experiment.true_regret import measure
from deformpush.record import regret_table
from deformpush.record.finished import FinishedRun
from deformpush.record.folder import RunFolder
from deformpush.record.poses import read_pictures, read_poses
from deformpush.record.regret_table import PUSHES
from deformpush.record.saved_config import read_config
from deformpush.record.status import run_status
from deformpush.record.summary import Summary, counted
from deformpush.study import bottom_view_svg, run_data, run_figure
from deformpush.study.find_runs import find_runs, is_run
from deformpush.study.page import table
from deformpush.study.tables import ERROR_HEADER, SHOWN_ERRORS, error_cells, run_rows
from deformpush.study.variants import Differences, differing
from deformpush.task import TERMS

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_alone = threading.RLock()
"""Hydra's state and the number of threads belong to the process: its runs are made one after the other."""


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """A run that has ended, read from its folder."""

    finished: FinishedRun

    @property
    def name(self) -> str:
        """Of the folder; inside a sweep, what tells it from the other runs."""
        return self.finished.name

    @property
    def folder(self) -> Path:
        """Where its files are."""
        return self.finished.folder.path

    @property
    def summary(self) -> Summary:
        """How it ended: what summary.json holds."""
        return self.finished.summary

    @property
    def pushes(self) -> "pd.DataFrame":
        """What pushes.csv holds: a row for each k, row 0 the state before any push (SI units)."""
        return self.finished.pushes

    @cached_property
    def contours(self) -> np.ndarray:
        """Contour of the object after push k `(K+1, M, 2)` (m).

        Raises:
            OSError, ValueError: contours.npz cannot be read.
        """
        return read_poses(self.finished.folder.contours).contours

    @cached_property
    def config(self) -> dict[str, Any]:
        """All settings, nested, as config.yaml has them."""
        return deepcopy(read_config(self.finished.folder.config))

    def branch(self, push: int) -> Branch:
        """The run before one of its pushes, in a world of its own where another push can be made instead.

        Raises:
            UserError: there is no such push, or no state of the world before it was saved.
            DivergedError: the recorded push, made again from there, ends elsewhere.
        """
        return Branch(self.finished.folder, push)

    def regret(self, pushes: int = PUSHES) -> "pd.DataFrame":
        """What regret.csv holds, a row for each k from 1: what the best of `pushes` others would have gained.

        It is measured where it is not yet, and written into the run's folder; that takes a while.

        Raises:
            UserError: the world offers no branches, or the table that is there is of other pushes.
            DivergedError: the run does not repeat itself here.
        """
        import pandas as pd

        with _alone:
            measure(self.finished.folder, self.folder, pushes)
        return pd.DataFrame(regret_table.read(self.folder / regret_table.REGRET))

    def figure(self) -> "Figure":
        """The paper's Fig. 2 of this run.

        Raises:
            OSError, ValueError: contours or pictures cannot be read.
        """
        with matplotlib.rc_context(run_figure.STYLE):
            return run_figure.figure(run_data.read(self.finished.folder))

    def __repr__(self) -> str:
        errors = ", ".join(f"{term.name} {term.show(self.finished.error(term)[-1])}" for term in TERMS)
        return f"<Run {self.finished.title}: {self._ended}; {errors}; {self.folder}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: how it ended, errors beside their stop values, the last bottom view."""
        run = self.finished
        rows = [
            ["", *ERROR_HEADER],
            ["at the end", *error_cells([run.error(one)[-1] for one in SHOWN_ERRORS])],
            ["stop value", *error_cells([run.stop(one) for one in SHOWN_ERRORS])],
        ]
        text = f"<p><b>{escape(run.title)}</b>: {escape(self._ended)} ({escape(self.summary.reason)})"
        return f"{text}<br>{escape(str(self.folder))}</p>{table(rows)}{self._last_view()}"

    @property
    def _ended(self) -> str:
        return f"{self.summary.status} after {counted(self.summary.pushes)}"

    def _last_view(self) -> str:
        """The object at the end, small; nothing where it cannot be read."""
        folder = self.finished.folder
        try:
            poses, pictures = read_poses(folder.contours), read_pictures(folder.views)
        except (OSError, ValueError):
            return ""
        k = min(len(poses.contours), len(pictures)) - 1
        view = bottom_view_svg.still(poses, k, pictures[k], bottom_view_svg.square_around([poses]))
        return f'<div style="width:18em">{view}</div>'


@dataclass(frozen=True, eq=False, repr=False)
class Sweep:
    """The finished runs of a folder, side by side."""

    folder: Path
    runs: Sequence[Run]
    skipped: Mapping[str, str]
    """Why others are left out, by name."""

    @cached_property
    def differences(self) -> Differences:
        """The settings that are not the same in all runs: full key -> value in each run."""
        return differing([run.finished for run in self.runs])

    @cached_property
    def pushes(self) -> "pd.DataFrame":
        """All rows of all pushes.csv, each behind the name of its run and the settings that differ."""
        import pandas as pd

        frames = []
        for i, run in enumerate(self.runs):
            columns = run.finished.columns
            same = {"run": run.name, **{key: values[i] for key, values in self.differences.items()}}
            frames.append(pd.DataFrame({k: [v] * len(columns["k"]) for k, v in same.items()} | dict(columns)))
        return pd.concat(frames, ignore_index=True)

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """A row a run: its name, the settings that differ, and what summary.json holds."""
        import pandas as pd

        rows = []
        for i, run in enumerate(self.runs):
            settings = {key: values[i] for key, values in self.differences.items()}
            rows.append({"run": run.name, **settings, **run.summary.flat()})
        return pd.DataFrame(rows)

    def __repr__(self) -> str:
        return f"<Sweep of {len(self.runs)} runs, {len(self.skipped)} skipped; {self.folder}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: a row a run, and what is left out."""
        left = "".join(f"<br>skipped {escape(name)}: {escape(why)}" for name, why in self.skipped.items())
        rows = run_rows([run.finished for run in self.runs], self.differences)
        return f"<p>{escape(str(self.folder))}{left}</p>{table(rows)}"


def compose(*settings: str, config_dir: str | Path | None = None, **values: object) -> Setup:
    """The checked components of a run.

    Args:
        *settings: as on the command line: "object=meat", "acq.w=2.0".
        config_dir: folder of your own YAML files and classes.
        **values: top-level settings and groups, such as seed=3 or object="meat".

    Raises:
        UserError: names the setting that is wrong, in the line that the command line would print.
    """
    overrides = [*settings, *(f"{key}={_written(value)}" for key, value in values.items())]
    for text in overrides:
        if text.lstrip("+~").startswith(NOT_IN_NAMES):
            raise UserError(f"{text}: for the command line alone; folder= says where a run goes")
    with _alone:
        own = [] if config_dir is None else [use_config_dir(str(config_dir))]
        return read(config.compose([*own, *overrides]))


def run(
    *settings: str | Setup,
    folder: str | Path | None = None,
    config_dir: str | Path | None = None,
    progress: bool = True,
    **values: object,
) -> Run:
    """Make a run; its files are those that the command line would write with the same settings.

    Args:
        *settings: as for `compose`, or the one thing that `compose` returned.
        folder: new or empty folder for its files; None: a dated one in runs/, as on the command line.
        config_dir: as for `compose`.
        progress: whether to show a bar.
        **values: as for `compose`.

    Raises:
        UserError: a setting is wrong, or the folder cannot be used.
    """
    with _alone, one_thread():
        setup = _setup(settings, config_dir, values)
        path = _dated(setup) if folder is None else Path(folder).absolute()
        make_run(setup, path, Verbosity.BAR_ONLY if progress else Verbosity.SILENT)
    return Run(find_runs([path]).runs[0])


def load(folder: str | Path) -> Run | Sweep:
    """A run that has ended, or all of those that lie below a folder.

    Raises:
        UserError: no finished run is there.
    """
    path = Path(folder).absolute()
    found = find_runs([path])
    if is_run(path):
        return Run(found.runs[0])
    listed = [job.name for job in manifest.read(path) if not is_run(path / job.name)]
    skipped = dict(found.skipped) | {name: run_status(RunFolder(path / name)).text for name in listed}
    return Sweep(path, [Run(one) for one in found.runs], skipped)


def _setup(
    settings: Sequence[str | Setup], config_dir: str | Path | None, values: Mapping[str, object]
) -> Setup:
    """What `run` was given, composed if it is not yet.

    Raises:
        UserError: a setting is wrong.
        TypeError: there are settings beside a composed one.
    """
    texts = [one for one in settings if isinstance(one, str)]
    made = [one for one in settings if isinstance(one, Setup)]
    if not made:
        return compose(*texts, config_dir=config_dir, **values)
    if len(settings) > 1 or values:
        raise TypeError("a composed Setup stands alone: give the other settings to deformpush.compose")
    return made[0]


def _written(value: object) -> str:
    """A value as the command line has it; text stands as it is."""
    if isinstance(value, str):
        return value
    return json.dumps(value.tolist() if isinstance(value, np.generic | np.ndarray) else value)


def _dated(setup: Setup) -> Path:
    """A free folder, named as conf/config.yaml names one; `-2` and so on behind it where that is taken."""
    options, now = setup.options, datetime.now()
    name = f"{now:%H%M%S}-{options['object']}-{options['acquisition']}-s{setup.seed}"
    path = Path("runs", f"{now:%Y-%m-%d}", name).absolute()
    others = (path.with_name(f"{path.name}-{n}") for n in count(2))
    return path if not path.exists() else next(one for one in others if not one.exists())
