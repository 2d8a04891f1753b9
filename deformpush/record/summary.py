"""How a run ended, as the keys of summary.json."""

from dataclasses import dataclass
from typing import Literal

Status = Literal["reached", "budget", "failed", "interrupted"]
"""interrupted: from outside (Ctrl-C, a full disk); `resume` continues it."""


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
