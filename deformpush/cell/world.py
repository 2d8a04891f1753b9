"""What a world offers to the loop, whichever engine stands behind it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from deformpush.cell.push import ToolPath
from deformpush.push_record import Moment, Strain

Array = np.ndarray


class SimulationError(RuntimeError):
    """The simulation broke down: it exploded, or the arm cannot do what was asked."""


@dataclass
class Outcome:
    """What one push cost and what was seen of it."""

    steps: int = 0
    step_s: float = 0.0
    """Wall time inside the engine (s)."""
    sim_s: float = 0.0
    """Simulated time (s)."""
    tip_error: float = 0.0
    """Largest distance of the tool from its commanded path while pushing (m)."""
    motion: list[Moment] = field(default_factory=list)
    film: list[Array] = field(default_factory=list)
    """Mesh nodes `(N, 3)` (m) whenever the camera took a picture while the tool pushed."""
    strain: Strain | None = None
    """None where the world does not measure it."""

    @contextmanager
    def stepping(self, steps: int, dt: float) -> Iterator[None]:
        """Count engine steps and the time spent in them."""
        began = perf_counter()
        yield
        self.step_s += perf_counter() - began
        self.steps += steps
        self.sim_s += steps * dt


class World(Protocol):
    """A table, an object on it, a tool, and a camera below."""

    def image(self) -> Array:
        """What the camera sees: RGB `(H, W, 3)` uint8, laid out as `deformpush.cell.camera.Camera` says."""

    def push(self, path: ToolPath) -> Outcome:
        """Push along the path, retreat, let the object come to rest.

        Raises:
            SimulationError: the path is out of reach (nothing has moved), or the simulation exploded.
        """

    def nodes(self) -> Array | None:
        """Mesh nodes `(N, 3)` in metres, or None."""

    def strain(self) -> Array | None:
        """Largest strain at each mesh node `(N,)` (-), or None where it is not measured."""

    def joints(self) -> dict[str, float]:
        """Arm joint angles by name (rad), empty without an arm."""

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` the tool can take: bool `(P,)`."""

    def scenery(self) -> dict[str, Any]:
        """What a recorder may draw: mesh_triangles, arm_urdf, arm_base, table_half_size, table_centre."""

    def close(self) -> None:
        """Free the engine."""
