"""What crosses from the loop to everything that records, compares or replays."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

COLUMNS = [
    "k",
    "phase",
    "kappa",
    "d",
    "xi",
    "e_c",
    "e_theta",
    "e_gamma",
    "e_T",
    "position_error_m",
    "angle_error_rad",
    "acq",
    "xi_mean",
    "xi_std",
    "kappa_min",
    "kappa_max",
    "d_min",
    "d_max",
    "steps",
    "step_s",
    "render_s",
    "decide_s",
    "record_s",
    "strain_p99_peak",
    "strain_top10_peak",
    "strain_max_peak",
    "strain_residual",
    "limit_exceeded",
    "speed",
]
"""Of pushes.csv, in this order. Older tables end before the columns of strain."""


@dataclass(frozen=True)
class RunInfo:
    """What stays the same during a run. Lengths in metres, angles in radians, table frame."""

    title: str
    config_yaml: str
    """The resolved configuration, as text."""
    object_name: str
    model: str
    acquisition: str
    optimizer: str
    seed: int
    initial_samples: int
    max_pushes: int
    camera: Any
    """`deformpush.cell.camera.Camera`."""
    goal_c: np.ndarray
    """Goal centroid c_d `(2,)`."""
    goal_theta: float
    goal_outline: np.ndarray
    """Outline of the goal mask gamma_d at the goal pose `(G, 2)`."""
    stop_position_m: float
    stop_angle_rad: float
    stop_e_gamma: float
    outer_bounds: np.ndarray
    """`[[kappa_lo, kappa_hi], [d_lo, d_hi]]`."""
    tool_radius: float
    table_half_size: tuple[float, float, float]
    table_centre: tuple[float, float, float]
    mesh_triangles: np.ndarray | None = None
    """Surface triangles `(T, 3)` into the mesh nodes."""
    arm_urdf: str | None = None
    arm_base: tuple[float, float, float] = (0.0, 0.0, 0.0)
    strain_limit: float | None = None
    """Strain that harms the object (-); None where none is known."""

    def stop_errors(self, row: "PushRecord") -> tuple[float, float, float]:
        """Stops as (e_c, e_theta, e_gamma). `row` is any row of the run: its e_c gives the scale of (1).

        e_c is nan if the object lies exactly on its goal in that row.
        """
        scale = row.e_c / row.position_error_m if row.position_error_m > 0 else np.nan
        return self.stop_position_m * scale, self.stop_angle_rad / np.pi, self.stop_e_gamma


@dataclass(frozen=True)
class View:
    """What the camera saw between two pushes, and what was made of it."""

    image: np.ndarray
    """RGB `(H, W, 3)` uint8."""
    contour: np.ndarray
    """V_c `(M, 2)`, metres."""
    c: np.ndarray
    theta: float
    nodes: np.ndarray | None = None
    """Mesh nodes `(N, 3)`, metres; None where the world has no mesh."""
    joints: dict[str, float] = field(default_factory=dict)
    """Arm joint angles by URDF joint name, empty for a bare tool."""
    strain: np.ndarray | None = None
    """Largest strain at each mesh node `(N,)` (-); None where the world does not measure it."""


@dataclass(frozen=True)
class Decision:
    """The push the optimizer chose, where it will act, and why."""

    phase: str
    """initial | exploit | explore."""
    kappa: float
    d: float
    bounds: np.ndarray
    """Bounds the push was chosen within, `[[kappa_min, kappa_max], [d_min, d_max]]`."""
    speed: float = float("nan")
    """Of the tool (m/s), where it was chosen; nan: as the world is set."""
    acq: float = float("nan")
    xi_mean: float = float("nan")
    xi_std: float = float("nan")
    start: np.ndarray | None = None
    """Tool centre where the push starts `(2,)`, on the augmented contour (5)."""
    end: np.ndarray | None = None
    """Tool centre where the push ends `(2,)`."""
    effective: np.ndarray | None = None
    """Effective contour V_e `(M_e, 2)`, metres, from kappa = 0 to kappa = 1."""
    maps: dict[str, np.ndarray] = field(default_factory=dict)
    """`mean`, `std`, `acq` over a grid `(n_d, n_kappa)` of the outer bounds; empty without a model."""
    forecast: Any | None = None
    """`deformpush.optimizer.protocol.Forecast`, from models that know where the object will go."""
    info: dict[str, float] = field(default_factory=dict)
    """Named numbers worth a look: length scales, noise, jitter, evaluations."""


@dataclass(frozen=True)
class Moment:
    """One instant inside a push."""

    time_s: float
    """Simulated seconds since the push began."""
    tool: np.ndarray
    """Tool tip `(3,)`."""
    nodes: np.ndarray | None = None
    joints: dict[str, float] = field(default_factory=dict)
    strain: np.ndarray | None = None
    """As in `View`."""


@dataclass(frozen=True)
class Strain:
    """How much a push strained the object (-); `deformpush.mechanics.strain` says what is measured."""

    p99_peak: float
    """Largest strain during the push that 99 % of the volume did not exceed."""
    top10_peak: float
    """Largest mean over the most strained tenth of the volume during the push."""
    max_peak: float
    """Largest strain of any tetrahedron during the push."""
    residual: float
    """Strain that 99 % of the volume does not exceed at rest after the push."""
    limit: float | None = None
    """Strain that harms the object; None where none is known."""
    at_nodes: np.ndarray | None = field(default=None, repr=False, compare=False)
    """Largest strain at each mesh node during the push `(N,)`."""

    @property
    def exceeded(self) -> bool | None:
        """Whether more than 1 % of the volume was strained beyond the limit; None without a limit."""
        return None if self.limit is None else self.p99_peak > self.limit


@dataclass(frozen=True)
class PushRecord:
    """Everything about push k. Row 0 is the state before any push: it has no decision."""

    k: int
    after: View
    e_c: float
    e_theta: float
    e_gamma: float
    e_T: float
    position_error_m: float
    angle_error_rad: float
    decision: Decision | None = None
    xi: float = float("nan")
    steps: int = 0
    step_s: float = 0.0
    render_s: float = 0.0
    decide_s: float = 0.0
    sim_time_s: float = 0.0
    """Simulated seconds since the run began."""
    motion: tuple[Moment, ...] = ()
    """A few instants of the push, in order."""
    strain: Strain | None = None
    """None in row 0 and where the world does not measure it."""
