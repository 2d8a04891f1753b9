"""What every optimizer, the paper's and its rivals, gives and takes."""

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np


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


class State(Protocol):
    """What a model or rival may want to know of the object. The paper's optimizer asks for none of it."""

    contour: np.ndarray
    c: np.ndarray
    theta: float


class Optimizer(Protocol):
    """Ask for a push, make it, tell how the total error changed."""

    def ask(self, state: Any | None = None) -> Proposal:
        """Choose the next push. Asking twice gives the same push."""

    def tell(self, u: np.ndarray, xi: float, state: Any | None = None) -> None:
        """Learn that push u changed e_T by xi. Time advances by one push."""

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        """`mean`, `std`, `acq` `(n, n)` over (d, kappa) inside the outer bounds now; empty without a model."""
