"""What has been told so far, checked at the door."""

from collections.abc import Mapping
from typing import Any

import numpy as np


class History:
    """Pushes and their effects inside the outer bounds."""

    def __init__(self, outer: np.ndarray) -> None:
        """Empty, for pushes within `outer` `[[kappa_lo, kappa_hi], [d_lo, d_hi]]`."""
        self.outer = outer
        self.U = np.empty((0, 2))
        """(kappa, d) `(S, 2)`, d in metres."""
        self.xi = np.empty(0)
        self.rejected = 0
        """Tells refused because of what they said."""

    def __len__(self) -> int:
        """S, which is also the time of the next push."""
        return len(self.xi)

    def add(self, u: Any, xi: Any) -> None:
        """Append one push.

        Raises:
            ValueError: u is not two finite numbers inside the outer bounds, or xi not one finite number.
        """
        try:
            u, xi = self._checked(u, xi)
        except ValueError:
            self.rejected += 1
            raise
        self.U = np.vstack([self.U, u])
        self.xi = np.append(self.xi, xi)

    def _checked(self, u: Any, xi: Any) -> tuple[np.ndarray, float]:
        try:
            u, xi = np.array(u, float), np.array(xi, float)
        except (TypeError, ValueError):
            raise ValueError(f"tell: u={u!r} and xi={xi!r} must be numbers") from None
        if u.shape != (2,):
            raise ValueError(f"tell: u must have shape (2,) = (kappa, d), got {u.shape}")
        if xi.shape not in ((), (1,)):
            raise ValueError(f"tell: xi must be one number, got shape {xi.shape}")
        if not (np.isfinite(u).all() and np.isfinite(xi).all()):
            raise ValueError(f"tell: u={u.tolist()} and xi={xi.tolist()} must be finite")
        lo, hi = self.outer.T
        slack = 1e-9 * (hi - lo)
        if np.any(u < lo - slack) or np.any(u > hi + slack):
            raise ValueError(
                f"tell: u={u.tolist()} is outside the bounds [kappa, d] in {self.outer.tolist()}"
            )
        return np.clip(u, lo, hi), float(xi.reshape(()))

    def state(self) -> dict[str, Any]:
        """Arrays and numbers."""
        return {
            "U": self.U.copy(),
            "xi": self.xi.copy(),
            "rejected": self.rejected,
            "outer": self.outer.copy(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `state` returned.

        Raises:
            ValueError: it was saved under other outer bounds.
        """
        if not np.array_equal(state["outer"], self.outer):
            saved = np.asarray(state["outer"]).tolist()
            raise ValueError(f"restore: saved with outer bounds {saved}, now {self.outer.tolist()}")
        self.U, self.xi = np.array(state["U"], float).reshape(-1, 2), np.array(state["xi"], float)
        self.rejected = int(state["rejected"])
