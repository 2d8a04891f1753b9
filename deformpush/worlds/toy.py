"""A world without an engine: a rigid slab pushed quasi-statically, milliseconds a push."""

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Annotated

import cv2
import numpy as np
from annotated_types import Interval

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.push import ToolPath
from deformpush.cell.robot import Robot
from deformpush.cell.world import Moment, Outcome, Scenery, World, WorldError
from deformpush.mechanics.geometry import gyration, resample, rotation
from deformpush.mechanics.quasi_static import make_way, overlap
from deformpush.mechanics.rounding import METRES, NODES, RADIANS, rounded
from deformpush.worlds.fork import pictures_after
from deformpush.worlds.saved_state import Scene

Array = np.ndarray

FARTHEST = 100.0
"""Metres from the middle of the table: no picture shows an object that is farther away."""


@dataclass(frozen=True)
class Toy:
    """`world=toy`: for tests and for trying an optimizer; camera, paths and records are as elsewhere."""

    margin: Annotated[float, Interval(ge=0, le=0.1)]
    """The object is touched this far outside its surface (m)."""
    step: Annotated[float, Interval(ge=1e-5, le=0.01)]
    """Tool travel between two contact solutions (m)."""
    pressure_radius: Annotated[float, Interval(ge=0.01, le=100)]
    """Ratio of frictional moment to force, as a share of the object's radius of gyration (-)."""
    frames: Annotated[int, Interval(ge=0, le=100)]
    """Instants of each push that are kept for the recording."""

    def build(self, sheet: SoftObject, robot: Robot, camera: Camera, tool_radius: float) -> "ToyWorld":
        """Put the object on the table; the robot only limits where the tool may go."""
        return ToyWorld(self, sheet, camera, tool_radius)


class ToyWorld(World):
    """A rigid polygon moved by a frictionless tool; see `deformpush.mechanics.quasi_static`."""

    offers = frozenset({"film", "branches", "states"})

    def __init__(self, spec: Toy, sheet: SoftObject, camera: Camera, tool_radius: float) -> None:
        self.spec, self.camera, self.reach = spec, camera, tool_radius + spec.margin
        self.margin = spec.margin
        self.mesh = sheet.slab.mesh
        outline = resample(sheet.polygon, 256)
        self._middle = outline.mean(axis=0)
        self._body = outline - self._middle
        self._corners = sheet.polygon - self._middle
        self.theta = float(np.radians(sheet.start_deg))
        self.c = np.array(sheet.start) + rotation(self.theta) @ self._middle
        self.pressure = spec.pressure_radius * gyration(self._body)
        self._rgb = tuple(int(255 * v) for v in sheet.rgb)
        placed = np.array([*self.c, self.theta, self.reach])
        self._scene = Scene("toy", repr(spec).encode(), placed.tobytes(), self._body.tobytes())

    def push(self, path: ToolPath) -> Outcome:
        """Slide the object out of the tool's way, step by step; see `World.push`.

        Raises:
            WorldError: the tool does not come to rest outside the object.
        """
        began, outcome = perf_counter(), Outcome()
        steps = max(1, int(np.ceil((path.approach + path.d) / self.spec.step)))
        keep = set(np.unique(np.linspace(0, steps, self.spec.frames + 1, dtype=int)[1:]).tolist())
        for n, s in enumerate(np.linspace(0, path.approach + path.d, steps + 1)[1:], start=1):
            tool = path.start + s * path.direction
            self._make_way(tool)
            if n in keep:
                outcome.motion.append(Moment(float(s), np.append(tool, 0.0), self.nodes()))
                outcome.film.append(self.nodes())
        self.c, self.theta = rounded(self.c, METRES), float(rounded(self.theta, RADIANS))
        outcome.steps, outcome.step_s, outcome.sim_s = steps, perf_counter() - began, path.approach + path.d
        return outcome

    def _make_way(self, tool: Array) -> None:
        pose = np.array([*self.c, self.theta])
        pose = make_way(self._body, pose[None], tool[None], self.reach, self.pressure)[0]
        if overlap(self._body, pose, tool, self.reach) > 1e-5:
            raise WorldError("the toy world cannot move the object out of the tool's way")
        self.c, self.theta = pose[:2], float(pose[2])

    def picture(self) -> Array:
        """The object as a filled polygon on white."""
        n, shift = self.camera.pixels, 4
        picture = np.full((n, n, 3), 255, np.uint8)
        corners = self.camera.to_px(rounded(self._corners @ rotation(self.theta).T + self.c, NODES))
        cv2.fillPoly(picture, [np.round(corners * 2**shift).astype(np.int32)], self._rgb, shift=shift)
        return self.camera.through_lens(picture)

    def nodes(self) -> Array:
        """Mesh nodes `(N, 3)` (m), moved rigidly."""
        plan = (self.mesh.nodes[:, :2] - self._middle) @ rotation(self.theta).T + self.c
        return np.column_stack([rounded(plan, NODES), self.mesh.nodes[:, 2]])

    def can_reach(self, points: Array) -> Array:
        """Everywhere."""
        return np.ones(len(points), bool)

    def scenery(self) -> Scenery:
        """What a recorder may draw."""
        x, y = self.camera.centre
        half = self.camera.field / 2
        return Scenery((x, y, -0.025), (half, half, 0.025), self.mesh.surface())

    def pictures_after(self, paths: Sequence[ToolPath]) -> list[Array | None]:
        """The picture after each of these pushes."""
        return pictures_after(self, paths)

    def save(self) -> bytes:
        """The pose; see `World.save`."""
        return self._scene.pack(np.array([*self.c, self.theta]))

    def restore(self, state: bytes) -> None:
        """Return to a pose; see `World.restore`.

        Raises:
            ValueError: it is no state, a damaged one, or that of another world. Nothing has changed.
        """
        x, y, theta = self._scene.unpack(state, 3)
        if max(abs(x), abs(y)) > FARTHEST:
            raise ValueError("a damaged state: the object is not on the table")
        self.c, self.theta = np.array([x, y]), float(theta)
