"""What the bare tool is in every engine: a circle that it moves in, and neither arm nor joints."""

import numpy as np

from deformpush.cell.robot import BareTool
from deformpush.cell.world import WorldError

Array = np.ndarray


class Workspace:
    """The part of a drive that needs no engine."""

    urdf = None

    def __init__(self, spec: BareTool) -> None:
        self.spec = spec

    def can_reach(self, points: Array) -> Array:
        """Which tool positions `(P, 2)` lie in the workspace."""
        return np.linalg.norm(np.asarray(points) - self.spec.centre, axis=1) <= self.spec.reach

    def prepare(self, points: Array) -> None:
        """Make sure that the way lies in the workspace; the axes follow any that does.

        Raises:
            WorldError: it does not. Nothing has moved.
        """
        if len(outside := points[~self.can_reach(points)]):
            x, y = outside[0]
            raise WorldError(f"the tool cannot reach ({x:.3f}, {y:.3f}) m")

    def joints(self) -> dict[str, float]:
        """No arm, no joints."""
        return {}

    def close(self) -> None:
        """Nothing to free."""
