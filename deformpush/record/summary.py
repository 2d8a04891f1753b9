"""summary.json: how a run ended, and what its pushes add up to."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_type_hints

import numpy as np
from annotated_types import Ge

from deformpush.record.checked import Text, checked
from deformpush.record.files import read_json
from deformpush.record.folder import SUMMARY, RunFolder
from deformpush.record.table import FORCE, TIMES
from deformpush.task import ERROR_COLUMNS, TOTAL

if TYPE_CHECKING:
    from pydantic import BaseModel

Status = Literal["reached", "budget", "damaged", "failed", "interrupted"]
"""damaged: a push strained the object beyond its limit, and `task.stop.on_damage` ends the run then;
interrupted: from outside (Ctrl-C, a full disk); `resume` continues it."""


@dataclass(frozen=True)
class Summary:
    """The contents of summary.json, in its order. Times are sums (s)."""

    status: Status
    reason: str
    pushes: int
    """Pushes made, initial samples included."""
    initial_samples: int
    seed: int
    object: str
    model: str
    acquisition: str
    errors: dict[str, float]
    """After the last push, by `ERROR_COLUMNS`, which are keys of their own in the file."""
    wall_s: float
    step_s: float
    render_s: float
    decide_s: float
    record_s: float
    steps: int
    calibration: float | None = None
    """Share of the forecast outcomes inside their 95 % intervals; None without forecasts."""
    resumed: int | None = None
    """The push after which the run was last taken up again; None for a run in one piece."""
    strain_limit: float | None = None
    """Strain that harms the object (-); None where none is known."""
    strain_peak: float | None = None
    """Largest p99 strain of all pushes (-); None where none was measured."""
    exceedances: int | None = None
    """Pushes that went beyond a limit of the object; None where it has none that is measured."""
    strain_dose: float | None = None
    """Sum of the p99 peaks of all pushes (-), None where none was measured; see `Totals.strain_dose`."""
    force_limit: float | None = None
    """Force of the tool that harms the object (N); None where none is known."""
    force_peak: float | None = None
    """Largest force of the tool of all pushes (N); None where none was measured."""

    def flat(self) -> dict[str, Any]:
        """The keys of the file and their values, in order."""
        values: dict[str, Any] = {}
        for item in fields(self):
            value = getattr(self, item.name)
            values |= value if item.name == "errors" else {item.name: value}
        return values


PLAIN = {item.name: item.default is MISSING for item in fields(Summary) if item.name != "errors"}
"""Keys of the file that are no errors, and whether it must have them."""


def counted(pushes: int) -> str:
    """So many pushes, in words."""
    return f"{pushes} push{'' if pushes == 1 else 'es'}"


def write(folder: RunFolder, summary: Summary) -> None:
    """Write summary.json.

    Raises:
        OSError: no room or no permission.
    """
    folder.write_json(SUMMARY, summary.flat())


def read(folder: RunFolder) -> Summary:
    """Read summary.json; an error that another version did not know is nan.

    Raises:
        FileNotFoundError: there is none.
        ValueError: it is damaged or of another version; the message is one line.
    """
    try:
        found = read_known(folder, whole=True)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise ValueError(f"{SUMMARY} cannot be read ({error.strerror})") from error
    told = {name: found.pop(name) for name in ERROR_COLUMNS if name in found}
    needed = {name for name, must in PLAIN.items() if must}
    if wrong := (needed - set(found)) | (set(found) - set(PLAIN)) | ({TOTAL.column} - set(told)):
        raise ValueError(f"{SUMMARY} is of another version (differs in {', '.join(sorted(wrong)[:3])})")
    # A number that is not finite is null in the file, and so is what this run has not.
    values: dict[str, Any] = {
        name: np.nan if value is None and PLAIN[name] else value for name, value in found.items()
    }
    errors = {name: np.nan if told.get(name) is None else told[name] for name in ERROR_COLUMNS}
    return Summary(**values, errors=errors)


def read_known(folder: RunFolder, whole: bool = False) -> dict[str, Any]:
    """What summary.json holds of what this version knows, or with `whole` all it holds.

    Raises:
        FileNotFoundError: there is none.
        OSError: it cannot be read.
        ValueError: a value is not what it should be; the message is one line that names it.
    """
    found = checked(read_json(folder.summary), _model(), SUMMARY)
    return {key: value for key, value in found.items() if whole or key in PLAIN or key in ERROR_COLUMNS}


@cache
def _model() -> "type[BaseModel]":
    """What each value in summary.json may be; which of them there must be is another question."""
    from pydantic import ConfigDict, create_model

    count, number = Annotated[int, Ge(0)], float | None  # a number that is not finite is null
    kinds: dict[Any, Any] = {int: count, float: number, str: Text, int | None: count | None}
    hints = get_type_hints(Summary)
    known: dict[str, Any] = {name: (kinds.get(hints[name], hints[name]), None) for name in PLAIN}
    known |= dict.fromkeys(ERROR_COLUMNS, (number, None))
    return create_model("Summary", __config__=ConfigDict(strict=True), **known)


@dataclass
class Totals:
    """What the pushes of a run add up to, row by row."""

    seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(TIMES, 0.0))
    """Keyed by the names of `TIMES`."""
    steps: int = 0
    strains: list[float] = field(default_factory=list)
    """p99 peaks of the strain, as far as it was measured."""
    forces: list[float] = field(default_factory=list)
    """Peaks of the tool's force (N), as far as it was measured."""
    exceedances: int | None = None
    """Pushes beyond a limit of the object; None where none could be told."""

    def add(self, row: Mapping[str, Any]) -> None:
        """Count a row of pushes.csv, as it was written or as it was read."""
        for name in TIMES:
            self.seconds[name] += row[name]
        self.steps += row["steps"]
        for kept, name in ((self.strains, "strain_p99_peak"), (self.forces, FORCE[0])):
            if _known(row[name]):
                kept.append(row[name])
        if _known(row["limit_exceeded"]):
            self.exceedances = (self.exceedances or 0) + int(row["limit_exceeded"])

    @property
    def strain_dose(self) -> float | None:
        """Sum of the p99 peaks: what the object has been through.

        It lets many gentle pushes be held against few harsh ones. Over the limit it is the damage sum of
        Palmgren and Miner for a life that falls with the first power of the strain. No source says how these
        materials tire, so no higher power is claimed, and the sum has a meaning for objects without a limit.
        """
        return sum(self.strains) if self.strains else None


def _known(value: float | None) -> bool:
    """Whether a cell says something."""
    return value is not None and not np.isnan(value)
