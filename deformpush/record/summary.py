"""How a run ended, as the keys of summary.json."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Status = Literal["reached", "budget", "damaged", "failed", "interrupted"]
"""damaged: a push strained the object beyond its limit, and `task.stop.on_damage` ends the run then;
interrupted: from outside (Ctrl-C, a full disk); `resume` continues it."""


@dataclass(frozen=True)
class Summary:
    """The contents of summary.json, in its order. Errors are of the last contour, times are sums (s)."""

    status: Status
    reason: str
    pushes: int
    """Pushes made, initial samples included."""
    initial_samples: int
    seed: int
    object: str
    model: str
    acquisition: str
    e_c: float
    e_theta: float
    e_gamma: float
    e_T: float
    position_error_m: float
    angle_error_rad: float
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
    """Largest p99 strain of all pushes (-). This and what follows: None where no strain was measured."""
    exceedances: int | None = None
    """Pushes whose p99 strain went beyond the limit; None without a limit."""
    strain_dose: float | None = None
    """Sum of the p99 peaks of all pushes (-); see `strains`."""


@dataclass(frozen=True)
class Strains:
    """A run's strain in three numbers, as in `Summary`."""

    peak: float | None
    exceedances: int | None
    dose: float | None


def strains(peaks: Sequence[float], limit: float | None) -> Strains:
    """Sum up the p99 peaks of a run's pushes; all None without any.

    The dose is their sum: what the object has been through, by which a way of many gentle pushes can be held
    against one of few harsh ones. Over the limit it is the damage sum of Palmgren and Miner for a life that
    falls with the first power of the strain. No source says how these materials tire, so no higher power is
    claimed, and the sum has a meaning for objects without a limit too.
    """
    if not peaks:
        return Strains(None, None, None)
    over = None if limit is None else sum(peak > limit for peak in peaks)
    return Strains(max(peaks), over, sum(peaks))
