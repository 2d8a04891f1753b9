"""What every optimizer, the paper's and its rivals, gives and takes.

Construction is the same for all: `Optimizer(**its own settings, parts=Parts(bounds=..., rng=..., ...))`.
`Parts` holds one component per config group; an optimizer reads those it works with and leaves the others
alone. A cell without
configuration files names only what differs from the paper:

    from deformpush.optimizer import ABO, Adaptive, Parts
    bounds = Adaptive(kappa=(0.0, 1.0), d=(0.01, 0.03))
    opt = ABO(S0=10, parts=Parts(bounds=bounds, rng=np.random.default_rng(0)))
    proposal = opt.ask()
    opt.tell(proposal.u, xi)
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from deformpush.gp.fit import MAP, Fit
from deformpush.gp.kernels import Kernel, Matern52
from deformpush.gp.means import Mean, Zero
from deformpush.model.base import Model
from deformpush.model.error import ErrorModel
from deformpush.model.rigid_push import RigidPush
from deformpush.optimizer.acquisition import LCB, Acquisition
from deformpush.optimizer.bounds import Bounds
from deformpush.optimizer.design import LHS, Design
from deformpush.optimizer.minimiser import Adam, Minimiser


@dataclass(frozen=True)
class Forecast:
    """Where a push is expected to bring the object (table frame, metres, radians)."""

    mean: np.ndarray
    """Centroid x, y, angle, e_gamma `(4,)` after the push."""
    cov: np.ndarray
    """Their covariance `(4, 4)`, noise included."""


@dataclass(frozen=True)
class Proposal:
    """A push to make next. `nan` where there is no model (initial design, random, greedy)."""

    u: np.ndarray
    """(kappa, d) `(2,)`, d in metres."""
    phase: str
    """initial | exploit | explore."""
    bounds: np.ndarray
    """`[[kappa_min, kappa_max], [d_min, d_max]]` that u was chosen within."""
    acq: float = float("nan")
    mean: float = float("nan")
    std: float = float("nan")
    info: dict[str, float] = field(default_factory=dict)
    forecast: Forecast | None = None
    """Only from models that know where the object will go."""
    speed: float = float("nan")
    """Of the tool (m/s), where it is chosen too; nan: as the world is set."""


@dataclass(frozen=True)
class Parts:
    """One component per config group, and what is only known at run time."""

    bounds: Bounds
    rng: np.random.Generator
    closed: bool = False
    """Whether kappa = 0 and kappa = 1 are the same point of the effective contour."""
    kernel: Kernel = field(default_factory=Matern52)
    mean: Mean | RigidPush = field(default_factory=Zero)
    fit: Fit = field(default_factory=MAP)
    model: Model = field(default_factory=ErrorModel)
    acquisition: Acquisition = field(default_factory=LCB)
    minimiser: Minimiser = field(default_factory=Adam)
    design: Design = field(default_factory=LHS)


class State(Protocol):
    """What may be told of the object: `bounds.taper` looks at the error, `model=motion` at all of it."""

    contour: np.ndarray
    """V_c `(M, 2)`, metres, table frame."""
    c: np.ndarray
    """Centroid `(2,)`."""
    theta: float
    effective: np.ndarray
    """V_e `(M_e, 2)` from kappa = 0 to kappa = 1."""
    goal_c: np.ndarray
    goal_theta: float
    e_T_share: float
    """e_T now over e_T at the start."""
    e_gamma: float
    strain: float
    """Peak strain of the push that led here (-), nan where unknown."""
    pressed: Callable[[], Sequence[np.ndarray]]
    """Contours under the tool during that push; none where unknown."""
    at_rest: Callable[[], Sequence[np.ndarray]]
    """The contour now, made out in the same way; none where unknown."""
    speed: float
    """Tool speed of that push (m/s), nan where it was not chosen."""
    total_error: Callable[..., Any]
    """(x, y, theta, e_gamma) -> e_T; see `deformpush.task.TotalError`."""
    paths: Callable[[np.ndarray], Sequence[Any]]
    """Pushes U `(n, 2)` -> where each would go; see `deformpush.cell.push.ToolPath`."""


class Optimizer(Protocol):
    """Ask for a push, make it, tell how the total error changed."""

    @property
    def S0(self) -> int:
        """Initial samples (0 for those that need none)."""

    def ask(self, state: Any | None = None) -> Proposal:
        """Choose the next push. Asking twice gives the same push."""

    def tell(self, u: np.ndarray, xi: float, before: Any | None = None, after: Any | None = None) -> None:
        """Learn that push u changed e_T by xi, the state from `before` to `after`. Time advances by one."""

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """`mean`, `std`, `acq` `(n, n)` over (d, kappa) in the outer bounds now; empty without a model."""

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays, numbers and strings only."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there."""
