"""What moves the tool in an engine: the contract of a drive."""

from typing import Protocol

import numpy as np

Array = np.ndarray


class Drive(Protocol):
    """Moves the tool in one world."""

    @property
    def urdf(self) -> str | None:
        """File of the arm; None without one."""

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` (m) the tool can take: bool `(P,)`."""

    def prepare(self, points: Array) -> None:
        """Plan the way through tool positions `(P, 2)`, at most a few millimetres apart.

        Raises:
            WorldError: it cannot be gone. Nothing has moved.
        """

    def place(self, xy: Array) -> None:
        """Put the tool there at rest, while it is clear of the object; costs no physics step."""

    def follow(self, xy: Array, velocity: Array) -> None:
        """For the coming step: be at `xy` (m), moving at `velocity` (m/s), both on the prepared way."""

    def tip(self) -> Array:
        """Tool tip `(3,)` (m)."""

    def park(self) -> None:
        """Take the tool out of the picture; costs no physics step."""

    def joints(self) -> dict[str, float]:
        """Joint angles by URDF name (rad); empty without an arm."""

    def close(self) -> None:
        """Free what it holds."""
