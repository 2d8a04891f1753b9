"""Entities `scene/*`: table, goal, soft object, arm or tool in 3D, with the moments inside each push."""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import rerun as rr
from rerun.urdf import UrdfTree

from deformpush.cell.world import Moment
from deformpush.push_record import Action, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.viewer.panel import PUSH, SIM_TIME, Panel, Times, columns

LIFT = 0.002
"""Lines on the table are drawn this far above it (m), so that they do not flicker."""
TOOL_LENGTH = 0.1
FULL_STRAIN = 0.2
"""Strain that gets the palest colour where no limit is known."""
MOVING = ("revolute", "continuous", "prismatic")
"""Joints that have an angle."""


class Scene(Panel):
    """The mesh keeps its triangles and gets new vertices; its colour is the strain, where it is measured.

    On `sim_time` that is the strain of the moment. Between pushes hardly any is left, so on the timeline
    `push` it is the largest at each node during the push before.
    """

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log table, goal, triangles, and the arm or the tool."""
        scenery, nodes = info.scenery, first.view.nodes
        rec.log("scene", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        centre, half = [scenery.table_centre], [scenery.table_half_size]
        table = rr.Boxes3D(centers=centre, half_sizes=half, colors=palette.TABLE, fill_mode="solid")
        rec.log("scene/table", table, static=True)
        outline = info.target.outline
        goal = _lifted(np.vstack([outline, outline[:1]]), LIFT)
        rec.log("scene/goal", rr.LineStrips3D([goal], colors=palette.GOAL, radii=0.002), static=True)
        rec.log(
            "scene/next_push", rr.Arrows3D.from_fields(colors=palette.NEXT_PUSH, radii=0.003), static=True
        )
        self._limit = info.strain_limit
        self._mesh = nodes is not None and scenery.mesh_triangles is not None
        if self._mesh:
            triangles = rr.Mesh3D.from_fields(triangle_indices=scenery.mesh_triangles)
            rec.log("scene/object", triangles, static=True)
        self._arm = Arm(rec, scenery.arm_urdf, scenery.arm_base) if scenery.arm_urdf else None
        if self._arm is None:
            tool = rr.Cylinders3D(lengths=[TOOL_LENGTH], radii=[info.tool_radius], colors=palette.TOOL)
            rec.log("scene/tool", tool, rr.Cylinders3D.from_fields(fill_mode="solid"), static=True)
        self._height = 0.01 if nodes is None else float(nodes[:, 2].max())

    def decide(self, rec: rr.RecordingStream, action: Action) -> None:
        """Log the next push as an arrow, level with the top of the object."""
        start, end = _lifted(np.stack([action.path.start, action.path.end]), self._height)
        rec.log("scene/next_push", rr.Arrows3D.from_fields(origins=[start], vectors=[end - start]))

    def move(self, rec: rr.RecordingStream, motion: Sequence[Moment], began_s: float) -> None:
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

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log object and arm as they are after the push."""
        view, time_s = record.view, record.timing.sim_time_s
        if self._mesh and view.nodes is not None:
            strain = None if record.action is None else record.action.outcome.strain
            peak = None if strain is None else strain.at_nodes
            self._place(rec, {PUSH: [record.k]}, [view.nodes], [peak])
            self._place(rec, {SIM_TIME: [time_s]}, [view.nodes], [view.strain])
        if self._arm is not None:
            self._arm.place(rec, [view.joints], {PUSH: [record.k], SIM_TIME: [time_s]})
        rec.log("scene/next_push", rr.Clear(recursive=False))

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


class Arm:
    """Entities `scene/<robot>/*` and `scene/joints`: the links, logged once, and the joints that place them.

    Each instant is one row a joint, all in one entity and one batch.
    """

    def __init__(self, rec: rr.RecordingStream, urdf: str, base: tuple[float, float, float]) -> None:
        """Log the links and stand the arm on its base."""
        self._tree = UrdfTree.from_file_path(urdf, entity_path_prefix="scene")
        rec.send_chunks(self._tree.stream().drop(content=f"/scene/{self._tree.name}/collision_geometries/**"))
        root = self._tree.root_link().name
        stand = rr.Transform3D(translation=base, parent_frame="tf#/scene", child_frame=root)
        rec.log("scene/base", stand, static=True)
        self._names = [joint.name for joint in self._tree.joints() if joint.joint_type in MOVING]

    def place(self, rec: rr.RecordingStream, angles: Sequence[dict[str, float]], times: Times) -> None:
        """Log joint angles by joint name, one dict an instant. An instant without angles is left out."""
        known = [i for i, one in enumerate(angles) if set(self._names) <= set(one)]
        if not known:
            return
        names = pa.array([self._names] * len(known))
        values = pa.array([[angles[i][name] for name in self._names] for i in known])
        batch = self._tree.compute_joint_transform_batches(names, values).flatten()
        rows = rr.Transform3D.columns(
            translation=_numbers(batch, "translation", 3),
            quaternion=_numbers(batch, "quaternion", 4),
            parent_frame=batch.field("parent_frame").to_pylist(),
            child_frame=batch.field("child_frame").to_pylist(),
        )
        repeated = {name: np.repeat(np.asarray(at)[known], len(self._names)) for name, at in times.items()}
        rec.send_columns("scene/joints", columns(repeated), rows)


def strain_colours(strain: np.ndarray, limit: float | None) -> np.ndarray:
    """Colour of each node by its strain `(..., N)`: paler up to the limit, another colour beyond it."""
    colours = palette.ramp(strain / (limit or FULL_STRAIN), palette.STRAIN)
    return colours if limit is None else np.where((strain > limit)[..., None], palette.HARM, colours)


def _lifted(points: np.ndarray, height: float) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), height)])


def _numbers(batch: pa.Array, field: str, width: int) -> np.ndarray:
    return np.asarray(batch.field(field).flatten().to_numpy(zero_copy_only=False).reshape(-1, width))
