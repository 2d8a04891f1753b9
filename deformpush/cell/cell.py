"""A robot cell: world, camera and perception around one table, and how a push is laid out on it."""

import logging
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.effective import Effective
from deformpush.cell.observation import Observation, View
from deformpush.cell.perception import Perception, PerceptionError
from deformpush.cell.push import Push, ToolPath
from deformpush.cell.silhouette import silhouette
from deformpush.cell.world import World, WorldError

Array = np.ndarray

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Cell:
    """Everything around the table."""

    world: World
    camera: Camera
    perception: Perception
    layout: Push
    part: Effective

    def look(self, previous: Observation | None) -> tuple[View, float]:
        """Take a picture and make out the object in it; also the seconds this took.

        Raises:
            PerceptionError: there is no object in the picture, or not all of it.
        """
        began = perf_counter()
        picture = self.camera.rectified(self.world.picture())
        seen = self.perception.observe(picture, self.camera, previous)
        seconds = perf_counter() - began
        world = self.world
        return View(picture, seen, world.nodes(), world.joints(), world.strain()), seconds

    def outlines(self, looks: Sequence[Array | None]) -> tuple[Array, ...]:
        """Contours `(M, 2)` (m) of the object where its nodes `(N, 3)` were as given; none of those unknown.

        A silhouette is a little larger than the object's part of the picture, so these contours must be
        compared with one another only.
        """
        triangles = self.world.scenery().mesh_triangles
        if triangles is None:
            return ()
        blobs = (silhouette(nodes, triangles, self.camera) for nodes in looks if nodes is not None)
        return tuple(self.perception.outline(blob, self.camera) for blob in blobs if blob.any())

    def seen_after(self, U: Array, seen: Observation) -> list[Observation | None]:
        """What is seen after each of pushes U `(n, 2)`, each in a copy of the world; None where one fails."""
        return self.seen_along([self.reachable(u, seen)[1] for u in U], seen)

    def seen_along(self, paths: Sequence[ToolPath], seen: Observation) -> list[Observation | None]:
        """What is seen after a push along each of these paths, as in `seen_after`."""
        looks: list[Observation | None] = []
        for picture in self.world.pictures_after(paths):
            looks.append(None)
            if picture is not None:
                with suppress(PerceptionError):
                    looks[-1] = self.perception.observe(self.camera.rectified(picture), self.camera, seen)
        return looks

    def plan(self, u: Array, seen: Observation) -> ToolPath:
        """The path of push u = (kappa, d), as the robot is given it."""
        return self.layout.plan(u, seen, self.part).rounded()

    def can_follow(self, path: ToolPath) -> bool:
        """Whether the robot can reach a path, with room behind its start to come clear on the way back."""
        behind = path.start - self.layout.offset * path.direction
        return bool(self.world.can_reach(np.stack([behind, path.end])).all())

    def reachable(self, u: Array, seen: Observation) -> tuple[Array, ToolPath]:
        """The wanted push and its path, or the one nearest along the contour that the robot can reach.

        Raises:
            WorldError: the robot can reach no push of this length.
        """
        for shift in sorted(np.arange(-50, 51) / 100, key=abs):
            kappa = (u[0] + shift) % 1.0 if self.part.closed and shift else u[0] + shift
            if 0.0 <= kappa <= 1.0:
                path = self.plan(np.array([kappa, u[1]]), seen)
                if self.can_follow(path):
                    if shift:
                        log.warning(
                            "kappa = %.3f is out of the robot's reach; pushed at %.3f instead", u[0], kappa
                        )
                    return np.array([kappa, u[1]]), path
        raise WorldError(f"the object lies where the robot can reach no push of {u[1] * 1e3:.0f} mm")
