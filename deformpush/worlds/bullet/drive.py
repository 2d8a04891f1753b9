"""What moves the tool in Bullet: a body in its client, and which robot has which."""

from typing import Any, Protocol

from deformpush.cell.robot import BareTool, Robot
from deformpush.worlds.drive import Drive


class BulletDrive(Drive, Protocol):
    """Moves the tool in one client."""

    id: int
    """Of the body in the engine."""
    link: int
    """Of the tool."""


def drive(robot: Robot, client: Any, tool_radius: float) -> BulletDrive:
    """The drive of a robot, in one of Bullet's clients."""
    if isinstance(robot, BareTool):
        from deformpush.worlds.bullet.bare_tool import BareToolDrive

        return BareToolDrive(robot, client, tool_radius)
    from deformpush.worlds.bullet.arm import ArmDrive

    return ArmDrive(robot, client, tool_radius)
