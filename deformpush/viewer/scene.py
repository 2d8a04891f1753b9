"""Entities `scene/*`: table, goal, soft object, arm or tool in 3D, with the moments inside each push."""

from collections.abc import Sequence

import numpy as np
import rerun as rr

from deformpush.cell.world import Moment
from deformpush.push_record import Decision, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.viewer.arm import Arm
from deformpush.viewer.timelines import PUSH, SIM_TIME, Times, columns

LIFT = 0.002
"""Lines on the table are drawn this far above it (m), so that they do not flicker."""
TOOL_LENGTH = 0.1
FULL_STRAIN = 0.2
"""Strain that gets the palest colour where no limit is known."""


class Scene:
    """The mesh keeps its triangles and gets new vertices; its colour is the strain, where it is measured.

    On `sim_time` that is the strain of the moment. Between pushes hardly any is left, so on the timeline
    `push` it is the largest at each node during the push before.
    """

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
        self._limit = info.strain_limit
        self._mesh = first.after.nodes is not None and info.mesh_triangles is not None
        if self._mesh:
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
        if self._mesh and view.nodes is not None:
            field = None if record.strain is None else record.strain.at_nodes
            self._place(rec, {PUSH: [record.k]}, [view.nodes], [field])
            self._place(rec, {SIM_TIME: [record.sim_time_s]}, [view.nodes], [view.strain])
        if self._arm is not None:
            self._arm.place(rec, [view.joints], {PUSH: [record.k], SIM_TIME: [record.sim_time_s]})
        rec.log("scene/next_push", rr.Clear(recursive=False))

    def move(self, rec: rr.RecordingStream, motion: tuple[Moment, ...], began_s: float) -> None:
        """Log the moments of a push, a batch an entity, on `sim_time` alone."""
        times = {SIM_TIME: [began_s + moment.time_s for moment in motion]}
        nodes = [moment.nodes for moment in motion if moment.nodes is not None]
        if self._mesh and len(nodes) == len(motion):
            self._place(rec, times, nodes, [moment.strain for moment in motion])
        if self._arm is not None:
            self._arm.place(rec, [moment.joints for moment in motion], times)
        else:
            tips = np.stack([moment.tool for moment in motion])
            middles = tips + np.array([0.0, 0.0, TOOL_LENGTH / 2])
            rec.send_columns("scene/tool", columns(times), rr.Transform3D.columns(translation=middles))

    def _place(
        self,
        rec: rr.RecordingStream,
        times: Times,
        nodes: Sequence[np.ndarray],
        strains: Sequence[np.ndarray | None],
    ) -> None:
        """Log nodes and colours of several instants on one timeline."""
        known = [np.zeros(len(at)) if of is None else of for at, of in zip(nodes, strains, strict=True)]
        colours = strain_colours(np.concatenate(known), self._limit)
        vertices = rr.Mesh3D.columns(vertex_positions=np.concatenate(nodes), vertex_colors=colours)
        rec.send_columns("scene/object", columns(times), vertices.partition([len(one) for one in nodes]))


def strain_colours(strain: np.ndarray, limit: float | None) -> np.ndarray:
    """Colour of each node by its strain `(..., N)`: paler up to the limit, another colour beyond it."""
    colours = palette.ramp(strain / (limit or FULL_STRAIN), palette.STRAIN)
    return colours if limit is None else np.where((strain > limit)[..., None], palette.HARM, colours)


def _lifted(points: np.ndarray, height: float) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), height)])
