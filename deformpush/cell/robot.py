"""What carries the tool: the options of the group `robot`, for every world that has them."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Len


@dataclass(frozen=True)
class BareTool:
    """`robot=tool`: a cylinder that follows its path exactly, on two ideal axes."""

    tip_height: Annotated[float, Gt(0)]
    """Height of the tool's tip above the table while pushing (m)."""
    length: Annotated[float, Gt(0)]
    """Length of the cylinder (m)."""
    friction: Annotated[float, Ge(0)]
    """Coulomb coefficient of the tool's surface; the product with the object's acts."""
    centre: tuple[float, float]
    """Middle of the workspace (m, table frame)."""
    reach: Annotated[float, Gt(0)]
    """The tool moves within a circle of this radius around the centre (m)."""


@dataclass(frozen=True)
class KukaIiwa:
    """`robot=kuka_iiwa`: the arm, standing at the origin of the table frame, with a cylinder as its tool."""

    tip_height: Annotated[float, Gt(0)]
    """Height of the tool's tip above the table while pushing (m)."""
    length: Annotated[float, Gt(0)]
    """Length of the tool (m)."""
    friction: Annotated[float, Ge(0)]
    """Coulomb coefficient of the tool's surface; the product with the object's acts."""
    rest: Annotated[tuple[float, ...], Len(7, 7)]
    """Posture that redundancy is resolved towards (rad)."""
    park: Annotated[tuple[float, ...], Len(7, 7)]
    """Posture between pushes (rad)."""
    gain: Annotated[float, Interval(ge=0.01, le=1.0)]
    """Share of a joint's position error that its motor takes back in one step."""
    force: Annotated[float, Gt(0)]
    """Largest motor torque (N m)."""
    max_turn: Annotated[float, Gt(0)]
    """A joint that turns further than this between two points of a path has flipped (rad)."""


Robot = BareTool | KukaIiwa
