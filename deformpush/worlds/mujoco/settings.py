"""The option `world=mujoco`: its settings. MuJoCo itself is imported when a world is built."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from annotated_types import Interval

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.ranges import HalfLength, Metre
from deformpush.cell.robot import Robot
from deformpush.worlds.tool_motion import Motion

if TYPE_CHECKING:
    from deformpush.worlds.mujoco.world import MujocoWorld


@dataclass(frozen=True)
class Engine:
    """Numbers of the finite element simulation."""

    dt: Annotated[float, Interval(ge=1e-5, le=0.05)]
    """Time step that the object needs in Bullet (s)."""
    dt_scale: Annotated[float, Interval(ge=0.01, le=10)]
    """MuJoCo's time step, as a multiple of that."""
    damping: Annotated[float, Interval(ge=1e-6, le=1)]
    """Stiffness-proportional Rayleigh damping time beta (s)."""
    gravity: Annotated[float, Interval(gt=0, le=100)]
    """m/s^2."""
    impratio: Annotated[float, Interval(ge=1, le=1000)]
    """How much stiffer friction is than contact (-): held by friction alone, the object creeps the less."""
    masses: Literal["equal", "volume"]
    """How the mass is shared among the nodes: equally, or by the volume around each."""

    @property
    def step(self) -> float:
        """MuJoCo's time step (s)."""
        return self.dt * self.dt_scale

    @property
    def check_every(self) -> int:
        """Steps between looks at the mesh: eight of dt, as in Bullet."""
        return max(1, round(8 / self.dt_scale))


@dataclass(frozen=True)
class Mujoco:
    """`world=mujoco`: finite elements on a frictional table."""

    engine: Engine
    margin: Annotated[float, Interval(ge=5e-4, le=5e-3)]
    """Radius of the flex (m): the object floats this high and is touched this far outside."""
    motion: Motion
    table: tuple[Metre, Metre, HalfLength, HalfLength]
    """Middle x, y and half lengths x, y of the table (m), for drawing: the simulated one has no end."""

    def build(self, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float) -> "MujocoWorld":
        """Put table, object and tool into a fresh world.

        Raises:
            ValueError: this world has no such robot, or it holds its tool too high.
        """
        from deformpush.worlds.mujoco.world import MujocoWorld

        return MujocoWorld(self, sheet, robot, camera, tool_radius)
