"""What carries the tool: the options of the group `robot`, for every world that has them."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval, Len

from deformpush.cell.ranges import Place

Posture = Annotated[tuple[Annotated[float, Interval(ge=-6.3, le=6.3)], ...], Len(7, 7)]
"""Seven joint angles (rad)."""


@dataclass(frozen=True)
class BareTool:
    """`robot=tool`: a cylinder that follows its path exactly, on two ideal axes."""

    tip_height: Annotated[float, Interval(gt=0, le=1)]
    """Height of the tool's tip above the table while pushing (m)."""
    length: Annotated[float, Interval(gt=0, le=1)]
    """Length of the cylinder (m)."""
    friction: Annotated[float, Interval(ge=0, le=10)]
    """Coulomb coefficient of the tool's surface; the product with the object's acts."""
    centre: Place
    """Middle of the workspace (m, table frame)."""
    reach: Annotated[float, Interval(gt=0, le=10)]
    """The tool moves within a circle of this radius around the centre (m)."""


@dataclass(frozen=True)
class KukaIiwa:
    """`robot=kuka_iiwa`: the arm, standing at the origin of the table frame, with a cylinder as its tool."""

    tip_height: Annotated[float, Interval(gt=0, le=1)]
    """Height of the tool's tip above the table while pushing (m)."""
    length: Annotated[float, Interval(gt=0, le=1)]
    """Length of the tool (m)."""
    friction: Annotated[float, Interval(ge=0, le=10)]
    """Coulomb coefficient of the tool's surface; the product with the object's acts."""
    rest: Posture
    """Posture that redundancy is resolved towards (rad)."""
    park: Posture
    """Posture between pushes (rad)."""
    gain: Annotated[float, Interval(ge=0.01, le=1.0)]
    """Share of a joint's position error that its motor takes back in one step."""
    force: Annotated[float, Interval(gt=0, le=1e4)]
    """Largest motor torque (N m)."""
    max_turn: Annotated[float, Interval(gt=0, le=3.14)]
    """A joint that turns further than this between two points of a path has flipped (rad)."""


Robot = BareTool | KukaIiwa
