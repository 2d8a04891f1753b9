"""A run folder read back once the run has ended: how it went, and the settings it was made with."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from deformpush.record import table
from deformpush.record.folder import CONFIG, PROVENANCE, SUMMARY, RunFolder
from deformpush.record.provenance import read_provenance, short_commit
from deformpush.record.saved_config import SavedConfigError, read_config
from deformpush.record.summary import Summary
from deformpush.record.summary import read as read_summary
from deformpush.task import ErrorTerm, Quantity

if TYPE_CHECKING:
    import pandas as pd

Array = np.ndarray


class NotFinishedError(ValueError):
    """The folder holds no run that can be read; the message is the reason, in one line."""


@dataclass(frozen=True)
class FinishedRun:
    """One run as summary.json, config.yaml and pushes.csv tell it."""

    name: str
    folder: RunFolder
    summary: Summary
    columns: Mapping[str, table.Column]
    """The columns of pushes.csv, a value for each k."""
    settings: Mapping[str, Any]
    """Values by full key, such as `acq.w`; lists are values."""
    options: Mapping[str, str]
    """The chosen option of every config group."""
    commit: str
    """Short commit of the code, `+` when files differed from it, `?` where it was no checkout."""

    def error(self, quantity: Quantity) -> Array:
        """Size of an error after each push `(K+1,)`, in its unit."""
        return np.abs(np.asarray(self.columns[quantity.column], float)) * quantity.scale

    def stop(self, quantity: Quantity) -> float:
        """The value at which this error is small enough, in its unit; nan where there is none."""
        if not isinstance(quantity, ErrorTerm):
            return np.nan
        value = self.settings.get(f"task.stop.{quantity.stop}")
        if not isinstance(value, int | float):
            return np.nan
        return value * quantity.stop_scale * quantity.scale

    @cached_property
    def pushes(self) -> "pd.DataFrame":
        """The columns as a frame, made when it is asked for: a thousand of them take seconds."""
        import pandas as pd

        return pd.DataFrame(dict(self.columns))

    @cached_property
    def title(self) -> str:
        """Object, model, acquisition and seed."""
        made = self.summary
        return f"{made.object}, {made.model} model, {made.acquisition}, seed {made.seed}"


def read(folder: RunFolder, name: str) -> FinishedRun:
    """Read a run folder.

    Raises:
        NotFinishedError: the folder is missing, half-written, damaged or of another version.
    """
    if not folder.path.is_dir():
        raise NotFinishedError("no such folder")
    try:
        summary = read_summary(folder)
    except FileNotFoundError:
        raise NotFinishedError(f"no {SUMMARY}: it still runs, or was killed") from None
    except ValueError as error:
        raise NotFinishedError(str(error)) from error
    if summary.status == "interrupted":
        raise NotFinishedError(f"interrupted after {summary.pushes} pushes; resume continues it")
    try:
        columns = table.columns(folder.table)
    except FileNotFoundError:
        raise NotFinishedError(f"no {folder.table.name}") from None
    except OSError as error:
        raise NotFinishedError(f"{folder.table.name} cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise NotFinishedError(f"{folder.table.name} is damaged or of another version") from error
    if (rows := len(columns["k"])) != summary.pushes + 1:
        raise NotFinishedError(f"{folder.table.name} has {rows - 1} of {summary.pushes} pushes")
    whole = _config(folder)
    options = whole.pop("options", None) or {}
    if not isinstance(options, dict) or not all(
        isinstance(option, str | None) for option in options.values()
    ):
        raise NotFinishedError(f"{CONFIG} is damaged (options: must be the option of each group)")
    return FinishedRun(name, folder, summary, columns, flat(whole), options, _commit(folder))


def flat(node: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Values of nested settings by full key."""
    found: dict[str, Any] = {}
    for name, value in node.items():
        key = f"{above}.{name}" if above else str(name)
        found |= flat(value, key) if isinstance(value, Mapping) else {key: value}
    return found


def _config(folder: RunFolder) -> dict[str, Any]:
    try:
        return dict(read_config(folder.config))
    except FileNotFoundError:
        raise NotFinishedError(f"no {CONFIG}") from None
    except OSError as error:
        raise NotFinishedError(f"{CONFIG} cannot be read ({error.strerror})") from error
    except SavedConfigError as error:
        raise NotFinishedError(f"{CONFIG} is damaged ({error})") from error


def _commit(folder: RunFolder) -> str:
    """Commit of the code, from provenance.json; a run without one can still be compared."""
    try:
        return short_commit(read_provenance(folder.path / PROVENANCE)["git"])
    except (OSError, ValueError, KeyError, TypeError):
        return "?"
