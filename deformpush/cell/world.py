"""What a table with an object and a tool offers to the loop, be it an engine or a robot."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import ClassVar, Literal, Protocol

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.robot import Robot

Array = np.ndarray

Capability = Literal["strain", "film", "branches", "states", "force"]
"""What only some worlds have.

strain: it measures how much a push strains the object. film: the nodes of a mesh are known while the tool
pushes. branches: a push can be tried in a copy of the world. states: a state can be saved and returned to.
force: it measures the force between tool and object.
"""


class WorldError(RuntimeError):
    """A push cannot be made or its end cannot be trusted: out of reach, a simulation that exploded."""


@dataclass(frozen=True)
class Scenery:
    """What a recorder may draw around the object (table frame, metres)."""

    table_centre: tuple[float, float, float] = (0.55, 0.0, -0.025)
    table_half_size: tuple[float, float, float] = (0.4, 0.5, 0.025)
    mesh_triangles: Array | None = None
    """Surface triangles `(T, 3)` into the nodes of the mesh; None where there is no mesh."""
    arm_urdf: str | None = None
    """File of the arm; None where there is none to draw."""
    arm_base: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Moment:
    """One instant inside a push."""

    time_s: float
    """Simulated seconds since the push began."""
    tool: Array
    """Tool tip `(3,)` (m)."""
    nodes: Array | None = None
    """Mesh nodes `(N, 3)` (m)."""
    joints: dict[str, float] = field(default_factory=dict)
    """Arm joint angles by URDF joint name (rad)."""
    strain: Array | None = None
    """Largest strain at each mesh node `(N,)` (-)."""


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
    at_nodes: Array | None = field(default=None, repr=False, compare=False)
    """Largest strain at each mesh node during the push `(N,)`."""

    @property
    def exceeded(self) -> bool | None:
        """Whether more than 1 % of the volume was strained beyond the limit; None without a limit."""
        return None if self.limit is None else self.p99_peak > self.limit


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
    """A few instants of the push, in order."""
    film: list[Array] = field(default_factory=list)
    """Mesh nodes `(N, 3)` (m) whenever the camera took a picture while the tool pushed."""
    strain: Strain | None = None
    """None where the world does not measure it."""
    tool_force_peak: float | None = None
    """Largest force between tool and object on the way forth, mean over 10 ms (N); None where unknown."""
    tool_force_mean: float | None = None
    """Its mean on the way forth, from the first touch on (N); None where unknown."""
    force_limit: float | None = None
    """Force of the tool that harms the object (N); None where none is known."""

    @property
    def harm(self) -> list[str]:
        """Each limit that the push went beyond, in words."""
        found = []
        if (strain := self.strain) is not None and strain.exceeded:
            found.append(f"strained the object to {strain.p99_peak:.3g}, its limit is {strain.limit:g}")
        force, limit = self.tool_force_peak, self.force_limit
        if force is not None and limit is not None and force > limit:
            found.append(f"pressed on the object with {force:.3g} N, its limit is {limit:g} N")
        return found

    @property
    def exceeded(self) -> bool | None:
        """Whether the push went beyond a limit of the object; None where it has none that is measured."""
        strained = self.strain is not None and self.strain.limit is not None
        pressed = self.tool_force_peak is not None and self.force_limit is not None
        return bool(self.harm) if strained or pressed else None

    @contextmanager
    def stepping(self, steps: int, dt: float) -> Iterator[None]:
        """Count engine steps and the time spent in them."""
        began = perf_counter()
        yield
        self.step_s += perf_counter() - began
        self.steps += steps
        self.sim_s += steps * dt


class World(ABC):
    """A table, an object on it, a tool and a camera. A world must have `picture`, `push` and `can_reach`."""

    offers: ClassVar[frozenset[Capability]] = frozenset()
    """What this world has of what only some have."""
    margin: float = 0.0
    """The tool touches the object this far outside its visible contour (m)."""

    @abstractmethod
    def picture(self) -> Array:
        """What the camera sees: RGB `(H, W, 3)` uint8, laid out as `deformpush.cell.camera.Camera` says.

        A real camera's picture is given as it is: `camera=calibrated` rectifies it. A world that draws its
        picture draws that of the ideal camera, and sends it through `camera.through_lens`.
        """

    @abstractmethod
    def push(self, path: ToolPath) -> Outcome:
        """Push along the path, retreat, let the object come to rest.

        Raises:
            WorldError: the path is out of reach (nothing has moved), or what came of it cannot be trusted.
        """

    @abstractmethod
    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` (m) the tool can take: bool `(P,)`."""

    def nodes(self) -> Array | None:
        """Mesh nodes `(N, 3)` (m); None without a mesh."""
        return None

    def strain(self) -> Array | None:
        """Largest strain at each mesh node `(N,)` (-); None where it is not measured."""
        return None

    def joints(self) -> dict[str, float]:
        """Arm joint angles by name (rad); empty without an arm."""
        return {}

    def scenery(self) -> Scenery:
        """What a recorder may draw."""
        return Scenery()

    def pictures_after(self, paths: Sequence[ToolPath]) -> list[Array | None]:
        """The picture after each of these pushes, made in copies of the world; None where one fails.

        Only for worlds that offer `branches`.
        """
        raise NotImplementedError(f"{type(self).__name__} offers no branches")

    def save(self) -> bytes:
        """The state of object and tool, from which the same pushes lead to the same bits.

        Only for worlds that offer `states`.
        """
        raise NotImplementedError(f"{type(self).__name__} offers no states")

    def restore(self, state: bytes) -> None:
        """Return to a state that this world has saved, or another one built from the same settings.

        Raises:
            ValueError: it is no state, or that of another world. Nothing has changed.
        """
        raise NotImplementedError(f"{type(self).__name__} offers no states")

    def close(self) -> None:  # noqa: B027 - most worlds hold nothing
        """Free what the world holds."""


class WorldSpec(Protocol):
    """An option of the group `world`: its settings, and how the world is put up."""

    @property
    def margin(self) -> float:
        """The object is touched this far outside its visible contour (m)."""

    def build(self, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float) -> World:
        """Put table, object and tool up.

        Raises:
            ValueError: this world has no such robot, or cannot hold such an object.
        """
