"""What one push was and what stays the same during a run: all that recording and comparing know of either."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.observation import View
from deformpush.cell.push import ToolPath
from deformpush.cell.world import Capability, Outcome, Scenery
from deformpush.state import Proposal
from deformpush.task import TERMS, Errors, Stop, Target, Task

Array = np.ndarray


EFFECTIVE_POINTS = 100
"""So many are told of an effective contour."""


@dataclass(frozen=True)
class Timing:
    """Where the time went."""

    render_s: float = 0.0
    """Picture and perception (s)."""
    decide_s: float = 0.0
    """Asking and telling the optimizer (s)."""
    sim_time_s: float = 0.0
    """Simulated seconds since the run began."""


@dataclass(frozen=True)
class Action:
    """A push that was made: what was proposed, what the tool did, what came of it."""

    proposal: Proposal
    u: Array
    """(kappa, d) `(2,)` as made: what was proposed, or the nearest that the robot can reach."""
    path: ToolPath
    outcome: Outcome
    xi: float
    """Change of e_T."""
    effective: Array | None = None
    """Places `(EFFECTIVE_POINTS, 2)` (m) on the V_e it was chosen on, at even steps of kappa from 0 to 1."""
    maps: Mapping[str, Array] = field(default_factory=dict)
    """`mean`, `std`, `acq` over a grid `(n_d, n_kappa)` of the outer bounds; empty without a model."""


@dataclass(frozen=True)
class PushRecord:
    """Push k and the state after it. Row 0 is the state before any push; it has no action."""

    k: int
    view: View
    errors: Errors
    timing: Timing = Timing()
    action: Action | None = None


class Ending(NamedTuple):
    """How a run ended, and why in one line."""

    status: Literal["reached", "budget", "damaged", "failed"]
    reason: str

    @classmethod
    def of(cls, record: PushRecord, task: Task, max_pushes: int) -> "Ending | None":
        """How a run ends with this push; None while there is more to do."""
        if task.stop.on_damage and record.action is not None and (harm := record.action.outcome.harm):
            return cls("damaged", f"push {record.k} {' and '.join(harm)}")
        if task.reached(record.errors):
            return cls("reached", f"{task.stop_when} errors at or under their stop values")
        if record.k >= max_pushes:
            return cls("budget", f"the budget of {max_pushes} pushes is spent")
        return None


@dataclass(frozen=True)
class RunInfo:
    """What stays the same during a run (table frame, metres, radians)."""

    title: str
    config_yaml: str
    """The resolved configuration, as text."""
    options: Mapping[str, str]
    """The chosen option of every config group."""
    seed: int
    initial_samples: int
    max_pushes: int
    camera: Camera
    target: Target
    stop: Stop
    outer_bounds: Array
    """`[[kappa_lo, kappa_hi], [d_lo, d_hi]]`."""
    tool_radius: float
    scenery: Scenery
    strain_limit: float | None = None
    """Strain that harms the object (-); None where none is known."""
    force_limit: float | None = None
    """Force of the tool that harms the object (N); None where none is known."""
    offers: frozenset[Capability] = frozenset()
    """What the world has of what only some have."""

    def stops(self) -> Array:
        """Stop values in the order of `TERMS`, in SI units."""
        return np.array([self.stop.value(term) for term in TERMS])

    def error_stops(self) -> Array:
        """The same as errors (1)-(3)."""
        return np.array([term.relative(self.stop.value(term), self.target) for term in TERMS])
