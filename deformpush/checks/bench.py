"""What the physics gates examine: a world with the bare tool, and a lone object in its engine."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.robot import BareTool
from deformpush.checks.gate import Gate
from deformpush.worlds.finite_elements import FiniteElementWorld

Array = np.ndarray


@dataclass(frozen=True)
class Limits:
    """How far an engine may be off."""

    stiffness: float
    """Young's modulus, relative."""
    pose_dt: tuple[float, float]
    """Place of the object when the time step is halved, after a push in the middle and one off it (m)."""
    pose_mesh: tuple[float, float]
    """The same when the mesh is refined (m)."""
    strain_dt: float
    """Peak strain of a push when the time step is halved, relative."""
    strain_mesh: float
    """The same when the mesh is refined, relative."""


class LoneBody(Protocol):
    """An object in an engine, without a tool."""

    masses: Array
    """Of the nodes `(N,)` (kg)."""

    def nodes(self) -> Array:
        """Mesh nodes `(N, 3)` (m)."""

    def launch(self, speed: float) -> None:
        """Give all nodes this speed along x (m/s)."""

    def step(self, seconds: float) -> None:
        """Let time pass."""

    def close(self) -> None:
        """Free the engine."""


@dataclass(frozen=True)
class Bench(ABC):
    """The configured parts that the gates examine."""

    limits: ClassVar[Limits]

    spec: Any
    """The settings of the world: `build`, `margin`, and `engine` with `dt` and `gravity`."""
    sheet: SoftObject
    tool: BareTool
    camera: Camera
    tool_radius: float
    overrides: tuple[str, ...] = ()
    """Command line settings that lead to the same parts, for a second process."""

    @abstractmethod
    def gates(self) -> Iterator[Gate]:
        """Run one gate of this world after the other."""

    @abstractmethod
    def on_table(self, sheet: SoftObject) -> LoneBody:
        """An object on the table."""

    @abstractmethod
    def hung(self, sheet: SoftObject, pull: float) -> LoneBody:
        """An object hung by its left end, with `pull` (m/s^2) along x as its only gravity, and no table."""

    def world(self, **engine: float) -> FiniteElementWorld:
        """A world with the bare tool, some engine numbers changed."""
        spec = replace(self.spec, engine=replace(self.spec.engine, **engine))
        world = spec.build(self.sheet, self.tool, self.camera, self.tool_radius)
        assert isinstance(world, FiniteElementWorld)
        return world

    def path(self, d: float, aside: float = 0.0) -> ToolPath:
        """A push by `d` (m) in y against the object's lower side, `aside` (m) right of its middle."""
        x, y = self.sheet.start
        x += aside
        low = y + self.sheet.polygon[:, 1].min() - self.tool_radius - self.spec.margin
        return ToolPath(np.array([x, low - 0.01]), np.array([0.0, 1.0]), 0.01, d)
