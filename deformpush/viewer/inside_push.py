"""Entities `camera/inside/*`: outline of the object and the tool in the bottom view while a push is made."""

from collections.abc import Sequence

import numpy as np
import rerun as rr

from deformpush.cell.camera import Camera
from deformpush.cell.world import Moment
from deformpush.push_record import PushRecord, RunInfo
from deformpush.record import palette
from deformpush.viewer.panel import SIM_TIME, Panel, columns

LEVEL = 0.7
"""A face whose normal points down or up by at least this share is level."""


class InsidePush(Panel):
    """What the camera would see between two pictures, from the nodes of the mesh at the recorded moments.

    The picture below stays that of the state before the push, so the outline shows how far the object went.
    """

    def __init__(self, width: int) -> None:
        """`width` of the recorded picture in pixels."""
        self._width = width

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Find the outline among the nodes and log how it is drawn."""
        self._camera: Camera = info.camera
        self._outline: np.ndarray | None = None
        nodes, triangles = first.view.nodes, info.scenery.mesh_triangles
        if nodes is not None and triangles is not None:
            self._outline = outline(nodes, triangles)
        line = rr.LineStrips2D.from_fields(colors=palette.CONTOUR, radii=-1.5, draw_order=20)
        rec.log("camera/inside/outline", line, static=True)
        radius = info.tool_radius * self._camera.scale * self._width / self._camera.pixels
        tool = rr.Points2D.from_fields(colors=palette.TOOL, radii=radius, draw_order=33)
        rec.log("camera/inside/tool", tool, static=True)

    def move(self, rec: rr.RecordingStream, motion: Sequence[Moment], began_s: float) -> None:
        """Log the moments of a push, a batch an entity, on `sim_time` alone."""
        times = columns({SIM_TIME: [began_s + moment.time_s for moment in motion]})
        tips = self._px(np.stack([moment.tool[:2] for moment in motion]))
        rec.send_columns("camera/inside/tool", times, rr.Points2D.columns(positions=tips))
        nodes = [moment.nodes for moment in motion if moment.nodes is not None]
        if self._outline is not None and len(nodes) == len(motion):
            rows = rr.LineStrips2D.columns(strips=self._px(np.stack(nodes)[:, self._outline, :2]))
            rec.send_columns("camera/inside/outline", times, rows)

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Take the drawing away: the next picture shows what came of it."""
        rec.log("camera/inside", rr.Clear(recursive=True))

    def _px(self, points: np.ndarray) -> np.ndarray:
        return self._camera.to_picture(points, self._width)


def outline(nodes: np.ndarray, triangles: np.ndarray) -> np.ndarray | None:
    """Nodes `(n,)` along the rim of a slab's underside, the first one repeated at the end.

    Args:
        nodes: `(N, 3)` while the slab lies flat.
        triangles: its surface `(T, 3)`, wound the same way everywhere.

    Returns:
        The longest rim, or None where no face is level.
    """
    corners = nodes[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    level = np.abs(normal[:, 2]) > LEVEL * np.linalg.norm(normal, axis=1)
    below = corners[:, :, 2].mean(1) < (nodes[:, 2].min() + nodes[:, 2].max()) / 2
    sides = triangles[level & below][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()
    inner = {(b, a) for a, b in sides}
    following = {a: b for a, b in sides if (a, b) not in inner}
    rims: list[list[int]] = []
    while following:
        rim = list(following.popitem())
        while rim[-1] in following:
            rim.append(following.pop(rim[-1]))
        rims.append(rim)
    return np.array(max(rims, key=len)) if rims else None
