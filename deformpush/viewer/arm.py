"""Entities `scene/<robot>/*` and `scene/joints`: the arm's links and the joint angles that place them."""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import rerun as rr
from rerun.urdf import UrdfTree

from deformpush.push_record import RunInfo
from deformpush.viewer.timelines import Times, columns

MOVING = ("revolute", "continuous", "prismatic")


class Arm:
    """Links are logged once; each instant is one row a joint, all in one entity and one batch."""

    def __init__(self, rec: rr.RecordingStream, info: RunInfo, urdf: str) -> None:
        """Log the links and stand the arm on its base."""
        self._tree = UrdfTree.from_file_path(urdf, entity_path_prefix="scene")
        rec.send_chunks(self._tree.stream().drop(content=f"/scene/{self._tree.name}/collision_geometries/**"))
        root = self._tree.root_link().name
        base = rr.Transform3D(translation=info.arm_base, parent_frame="tf#/scene", child_frame=root)
        rec.log("scene/base", base, static=True)
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


def _numbers(batch: pa.Array, field: str, width: int) -> np.ndarray:
    return np.asarray(batch.field(field).flatten().to_numpy(zero_copy_only=False).reshape(-1, width))
