"""The data sheet of an object: shape, material, where it starts, what may be pushed."""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from annotated_types import Gt, Interval, Lt, MinLen

from deformpush.cell.effective import Effective
from deformpush.cell.ranges import Degrees, Place, Point, Share, Side
from deformpush.mechanics.material import Material
from deformpush.mechanics.meshing import Layout, MeshedSlab, mesh_outline


@dataclass(frozen=True)
class SoftObject:
    """A slab of even thickness."""

    outline: Annotated[tuple[Point, ...], MinLen(3)]
    """Plan about the start point (m): any polygon that does not meet itself."""
    thickness: Annotated[float, Interval(ge=5e-4, le=0.2)]
    """Metres."""
    cell: Annotated[float, Gt(0)]
    """Edge length of the tetrahedra in the plane (m)."""
    material: Material
    start: Place
    """Where the outline's origin lies at the start (m, table frame)."""
    start_deg: Degrees
    """Turn of the outline at the start (degrees, counter-clockwise)."""
    d: tuple[Side, Side]
    """Shortest and longest push (m)."""
    dt: Annotated[float, Interval(ge=1e-5, le=0.05)]
    """Time step its simulation needs to stay stable and accurate (s)."""
    effective: Effective
    """Which part of the contour may be pushed."""
    goal_mask: tuple[Side, Side] | None
    """Sides of a rectangular goal mask (m); null: the object's own shape."""
    e_gamma_stop: Annotated[float, Interval(gt=0, le=10)]
    """Shape error at which the task counts as done (-)."""
    rgb: tuple[Share, Share, Share]
    """Colour (0-1), to be found by the perception's HSV range."""
    strain_limit: Annotated[float, Gt(0), Lt(1)] | None = None
    """Strain that harms it (-), as a change of length over a length; null where none is known."""
    force_limit: Annotated[float, Gt(0)] | None = None
    """Force of the tool that harms it (N); null where none is known."""
    mesh: Layout = "auto"
    """How its cells lie: a grid (star-shaped outlines only), triangles (any), or the first that is good."""

    def __post_init__(self) -> None:
        # Says what is wrong with an outline before a run begins.
        _ = self.slab

    @cached_property
    def slab(self) -> MeshedSlab:
        """The mesh of its undeformed shape, of which quality it is, and whether the outline was reversed."""
        return mesh_outline(np.array(self.outline, float), self.thickness, self.cell, self.mesh)

    @property
    def polygon(self) -> np.ndarray:
        """The outline as an array `(V, 2)`, counter-clockwise."""
        return self.slab.outline.points
