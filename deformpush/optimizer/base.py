"""What every optimizer, the paper's and its rivals, gives and takes, and what most of them share.

Construction is the same for all: `Optimizer(**its own settings, parts=Components(bounds=..., rng=..., ...))`.
Without configuration files one names only what differs from the paper:

    from deformpush.optimizer import ABO, Adaptive, Components
    bounds = Adaptive(kappa=(0.0, 1.0), d=(0.01, 0.03))
    opt = ABO(S0=10, parts=Components(bounds=bounds, rng=np.random.default_rng(0)))
    proposal = opt.ask()
    opt.tell(proposal.u, xi)
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from deformpush.cell.world import Capability
from deformpush.gp.fit import MAP, Fit
from deformpush.gp.kernels import Kernel, Matern52
from deformpush.gp.means import Mean, Zero
from deformpush.mechanics import rounding
from deformpush.model.base import Model
from deformpush.model.error import ErrorModel
from deformpush.model.rigid_push import RigidPush
from deformpush.optimizer.acquisition import LCB, Acquisition
from deformpush.optimizer.bounds import Bounds
from deformpush.optimizer.design import LHS, Design
from deformpush.optimizer.history import History
from deformpush.optimizer.minimiser import Adam, Minimiser
from deformpush.state import Proposal, State


@dataclass(frozen=True)
class Components:
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


class Branches(Protocol):
    """What an optimizer that needs `branches` is given."""

    def e_T_after(self, U: np.ndarray) -> np.ndarray:
        """e_T `(n,)` after each of pushes U `(n, 2)`, tried in copies of the world; nan where one fails."""


class Optimizer(Protocol):
    """Ask for a push, make it, tell how the total error changed."""

    uses: ClassVar[frozenset[str]]
    """Config groups whose choice makes a difference to it; choosing an option of another one is refused."""

    @property
    def S0(self) -> int:
        """Initial samples (0 for those that need none)."""

    @property
    def needs(self) -> frozenset[Capability]:
        """What the world must offer."""

    def attach(self, branches: Branches) -> None:
        """Take the branches of the world, before the first ask. Only of use where they are needed."""

    def ask(self, state: State | None = None) -> Proposal:
        """Choose the next push. Asking twice gives the same push."""

    def tell(self, u: np.ndarray, xi: float, before: State | None = None, after: State | None = None) -> None:
        """Learn that push u changed e_T by xi, the state from `before` to `after`. Time advances by one."""

    def predict(self, U: np.ndarray, state: State | None = None) -> tuple[np.ndarray, np.ndarray] | None:
        """Forecast of xi for pushes U `(n, 2)` made next: mean and standard deviation `(n,)`, noise included.

        None without a model, or before it has enough samples. It changes no decision.
        """

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """`mean`, `std`, `acq` `(n, n)` over (d, kappa) in the outer bounds now; empty without a model."""

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays, numbers and strings only."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there."""


class AskTellOptimizer(ABC):
    """Answers depend on the seed and on what was told, on nothing else: repeatable and restorable."""

    uses: ClassVar[frozenset[str]] = frozenset({"bounds"})
    """Config groups whose choice makes a difference."""

    def __init__(self, parts: Components, S0: int) -> None:
        """Draw the S0 points of the design and the seed of all later draws."""
        self.history = History(parts.bounds.outer)
        self._bounds = parts.bounds
        self._design = self._in_outer(parts.design.points(S0, parts.rng)) if S0 else np.empty((0, 2))
        self._seed = int(parts.rng.integers(2**63))
        self._proposal: Proposal | None = None

    @property
    def needs(self) -> frozenset[Capability]:
        """Nothing that only some worlds have."""
        return frozenset()

    def attach(self, branches: Branches) -> None:  # noqa: B027 - of no use to most
        """See `Optimizer.attach`."""

    @property
    def rejected(self) -> int:
        """Tells refused so far."""
        return self.history.rejected

    def ask(self, state: State | None = None) -> Proposal:
        """Choose the next push: the next point of the design, then what the method says."""
        if self._proposal is None:
            S = len(self.history)
            in_design = len(self._design) > S
            proposal = self._initial(self._design[S], state) if in_design else self._choose(state)
            self._proposal = self._rounded(proposal)
        return self._proposal

    def tell(self, u: Any, xi: Any, before: State | None = None, after: State | None = None) -> None:
        """Learn that push u, asked for or not, changed e_T by xi.

        Raises:
            ValueError: u or xi is not finite, of the wrong shape, or outside the outer bounds; counted in
            `rejected`.
        """
        self.history.add(u, xi)
        self._proposal = None

    def predict(self, U: np.ndarray, state: State | None = None) -> tuple[np.ndarray, np.ndarray] | None:
        """Nothing: there is no model."""
        return None

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """Nothing: there is no model."""
        return {}

    def state(self) -> dict[str, Any]:
        """Everything needed to go on elsewhere: arrays and numbers only."""
        return self.history.state() | {"design": self._design.copy(), "seed": self._seed}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned; the next ask gives what it would have given there.

        Raises:
            ValueError: it was saved under other outer bounds or another S0.
        """
        design = np.asarray(state["design"], float).reshape(-1, 2)
        if len(design) != len(self._design):
            raise ValueError(f"restore: saved with S0={len(design)}, now S0={len(self._design)}")
        self.history.restore(state)
        self._design, self._seed = design, int(state["seed"])
        self._proposal = None

    def _initial(self, u: np.ndarray, state: State | None) -> Proposal:
        """The push for a point of the design `(2,)`, d in metres."""
        return Proposal(u.copy(), "initial", self.history.outer)

    @abstractmethod
    def _choose(self, state: State | None) -> Proposal:
        """The push after the design."""

    def _bounds_now(self, state: State | None) -> np.ndarray:
        share = None if state is None else state.e_T_share
        return self._on_grid(self._bounds.now(self.history.U, self.history.xi, share).T).T

    def _on_grid(self, U: np.ndarray) -> np.ndarray:
        """Pushes `(n, 2)` or `(2,)` as they are made: rounded, and within the outer bounds."""
        return np.clip(rounding.push(U), *self.history.outer.T)

    def _rounded(self, proposal: Proposal) -> Proposal:
        """The same on every machine; see `deformpush.mechanics.rounding`."""
        u, v = self._on_grid(proposal.u), proposal.speed
        speed = None if v is None else float(rounding.rounded(v, rounding.METRES_PER_SECOND))
        return replace(proposal, u=u, speed=speed)

    def _rng(self, purpose: int = 0) -> np.random.Generator:
        """The generator of this decision: the same whenever it is asked for."""
        return np.random.default_rng([self._seed, len(self.history), purpose])

    def _in_outer(self, unit: np.ndarray) -> np.ndarray:
        """Points of the unit square `(n, 2)` to (kappa, d in metres)."""
        lo, hi = self._bounds.outer.T
        return np.asarray(lo + unit * (hi - lo))
