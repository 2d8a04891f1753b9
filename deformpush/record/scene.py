"""Entities `scene/*`: table, goal, soft object, arm or tool in 3D, with the moments inside each push."""

import numpy as np
import rerun as rr

from deformpush import palette
from deformpush.record.arm import Arm
from deformpush.record.push_record import Decision, Moment, PushRecord, RunInfo
from deformpush.record.timelines import PUSH, SIM_TIME, columns

LIFT = 0.002
"""Lines on the table are drawn this far above it (m), so that they do not flicker."""
TOOL_LENGTH = 0.1
FULL_STRETCH = 0.1
"""Local stretch that gets the last colour: edges longer or shorter by a tenth."""


class Scene:
    """The mesh keeps its triangles and gets new vertices; its colour is the local stretch."""

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log table, goal, triangles, and the arm or the tool."""
        rec.log("scene", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        centre, half = [info.table_centre], [info.table_half_size]
        table = rr.Boxes3D(centers=centre, half_sizes=half, colors=palette.TABLE, fill_mode="solid")
        rec.log("scene/table", table, static=True)
        goal = _lifted(np.vstack([info.goal_outline, info.goal_outline[:1]]), LIFT)
        rec.log("scene/goal", rr.LineStrips3D([goal], colors=palette.GOAL, radii=0.002), static=True)
        rec.log(
            "scene/next_push", rr.Arrows3D.from_fields(colors=palette.NEXT_PUSH, radii=0.003), static=True
        )
        self._stretch = None
        if first.after.nodes is not None and info.mesh_triangles is not None:
            self._stretch = Stretch(first.after.nodes, info.mesh_triangles)
            rec.log("scene/object", rr.Mesh3D.from_fields(triangle_indices=info.mesh_triangles), static=True)
        self._arm = Arm(rec, info, info.arm_urdf) if info.arm_urdf else None
        if self._arm is None:
            tool = rr.Cylinders3D(lengths=[TOOL_LENGTH], radii=[info.tool_radius], colors=palette.TOOL)
            rec.log("scene/tool", tool, rr.Cylinders3D.from_fields(fill_mode="solid"), static=True)
        self._height = 0.01 if first.after.nodes is None else float(first.after.nodes[:, 2].max())

    def decide(self, rec: rr.RecordingStream, decision: Decision) -> None:
        """Log the next push as an arrow, level with the top of the object."""
        if decision.start is not None and decision.end is not None:
            start, end = _lifted(np.stack([decision.start, decision.end]), self._height)
            rec.log("scene/next_push", rr.Arrows3D.from_fields(origins=[start], vectors=[end - start]))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log object and arm as they are after the push."""
        view = record.after
        if self._stretch is not None and view.nodes is not None:
            colours = self._stretch.colours(view.nodes)
            rec.log("scene/object", rr.Mesh3D.from_fields(vertex_positions=view.nodes, vertex_colors=colours))
        if self._arm is not None:
            self._arm.place(rec, [view.joints], {PUSH: [record.k], SIM_TIME: [record.sim_time_s]})
        rec.log("scene/next_push", rr.Clear(recursive=False))

    def move(self, rec: rr.RecordingStream, motion: tuple[Moment, ...], began_s: float) -> None:
        """Log the moments of a push, a batch an entity, on `sim_time` alone."""
        times = {SIM_TIME: [began_s + moment.time_s for moment in motion]}
        nodes = [moment.nodes for moment in motion if moment.nodes is not None]
        if self._stretch is not None and len(nodes) == len(motion):
            together = np.concatenate(nodes)
            colours = self._stretch.colours(np.stack(nodes)).reshape(-1, 3)
            vertices = rr.Mesh3D.columns(vertex_positions=together, vertex_colors=colours)
            rec.send_columns("scene/object", columns(times), vertices.partition([len(one) for one in nodes]))
        if self._arm is not None:
            self._arm.place(rec, [moment.joints for moment in motion], times)
        else:
            tips = np.stack([moment.tool for moment in motion])
            middles = tips + np.array([0.0, 0.0, TOOL_LENGTH / 2])
            rec.send_columns("scene/tool", columns(times), rr.Transform3D.columns(translation=middles))


class Stretch:
    """Local stretch of the object: how far the edges around a node are from their first length."""

    def __init__(self, rest: np.ndarray, triangles: np.ndarray) -> None:
        """`rest` are the nodes `(N, 3)` of the object before any push."""
        sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        self._edges = edges = np.unique(sides, axis=0)
        self._rest = self._lengths(rest)
        at_node = np.zeros((len(edges), len(rest)))
        at_node[np.arange(len(edges))[:, None], edges] = 1.0
        self._mean = at_node / at_node.sum(0).clip(min=1)

    def __call__(self, nodes: np.ndarray) -> np.ndarray:
        """Mean of |length / first length - 1| over the edges at each node `(..., N, 3)`: `(..., N)`."""
        return np.asarray(np.abs(self._lengths(nodes) / self._rest - 1) @ self._mean)

    def colours(self, nodes: np.ndarray) -> np.ndarray:
        """Colour of each node `(..., N, 3)`."""
        return palette.ramp(self(nodes) / FULL_STRETCH, palette.STRAIN)

    def _lengths(self, nodes: np.ndarray) -> np.ndarray:
        ends = nodes[..., self._edges, :]
        return np.asarray(np.linalg.norm(ends[..., 0, :] - ends[..., 1, :], axis=-1))


def _lifted(points: np.ndarray, height: float) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), height)])
