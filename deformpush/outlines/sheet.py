"""The YAML of an object: an outline of its own, all else from an object that is there."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from deformpush.mechanics.mesh import TetMesh

Array = np.ndarray

DIGITS = 5
"""Of a coordinate in metres: hundredths of a millimetre."""
NEAR = (0.7, 1.4)
"""Objects of nearly the size of the one whose material they have are pushed as far as that one."""


@dataclass(frozen=True)
class Preset:
    """What an object is like whose material another one gets."""

    name: str
    area: float
    """m^2"""
    d: tuple[float, float]
    """Shortest and longest push (m)."""
    dt: float
    """Time step (s)."""
    thickness: float
    """m"""
    mass: float | None
    """kg; None where it is given by its density."""
    has_goal_mask: bool
    mesh: TetMesh


@dataclass(frozen=True)
class Shape:
    """What is its own."""

    points: Array
    """`(V, 2)` (m), counter-clockwise, about its centroid."""
    thickness: float
    cell: float
    mesh: TetMesh

    @property
    def area(self) -> float:
        """m^2."""
        x, y = self.points.T
        return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def rounded(points: Array) -> Array:
    """Points as the YAML has them."""
    return np.asarray(np.round(points, DIGITS) + 0.0)


def pushes(shape: Shape, preset: Preset) -> tuple[float, float]:
    """Shortest and longest push (m): as the preset has them, or in proportion to the size."""
    ratio = float(np.sqrt(shape.area / preset.area))
    if NEAR[0] <= ratio <= NEAR[1]:
        return preset.d
    ratio = min(max(ratio, 0.2), 2.0)
    low, high = (max(0.002, round(d * ratio, 3)) for d in preset.d)
    return low, max(high, low + 0.002)


def time_step(shape: Shape, preset: Preset) -> float:
    """Time step (s): the preset's, or less in proportion to the smallest height of a cell."""
    ratio = _smallest_height(shape.mesh) / _smallest_height(preset.mesh)
    hertz = np.ceil(1 / (preset.dt * min(1.0, ratio)) / 60) * 60
    return preset.dt if ratio >= 1 else float(1 / hertz)


def text(shape: Shape, preset: Preset, head: list[str]) -> str:
    """The YAML, `head` as its first lines."""
    low, high = pushes(shape, preset)
    dt = time_step(shape, preset)
    points = "\n".join(f"  - [{x:.{DIGITS}f}, {y:.{DIGITS}f}]" for x, y in rounded(shape.points))
    lines = [
        *(f"# {line}" for line in head),
        "defaults:",
        f"  - {preset.name} # material, limits, and all that does not stand here",
        "  - _self_",
        "outline: # m, counter-clockwise, about its centroid",
        points,
        f"thickness: {shape.thickness:g} # m",
        f"cell: {shape.cell:g} # m",
        f"d: [{low:g}, {high:g}] # m",
        f"dt: {dt!r} # s; 1/{1 / dt:.0f}",
    ]
    if preset.mass is not None:
        density = preset.mass / (preset.area * preset.thickness)
        lines += [
            "material:",
            f"  mass: null # that of {preset.name} over its volume is",
            f"  density: {density:.4g} # kg/m^3",
        ]
    if preset.has_goal_mask:
        lines += ["goal_mask: null # its own shape", "e_gamma_stop: 0.15 # - as for rect"]
    return "\n".join(lines) + "\n"


def _smallest_height(mesh: TetMesh) -> float:
    """Smallest height of a tetrahedron (m)."""
    corners = mesh.nodes[mesh.tetrahedra]
    faces = [
        np.linalg.norm(np.cross(corners[:, j] - corners[:, i], corners[:, k] - corners[:, i]), axis=1) / 2
        for i, j, k in combinations(range(4), 3)
    ]
    return float(np.min(3 * mesh.volumes / np.max(faces, axis=0)))
