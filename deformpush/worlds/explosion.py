"""The guard against a simulation that exploded unseen: engines report little or nothing of it."""

import numpy as np

from deformpush.cell.world import WorldError
from deformpush.mechanics.mesh import TetMesh, tet_volumes

Array = np.ndarray


class ExplosionGuard:
    """Looks at the nodes of one mesh."""

    def __init__(self, mesh: TetMesh) -> None:
        self._tetrahedra, self._volumes = mesh.tetrahedra, mesh.volumes
        self._size = float(np.ptp(mesh.nodes, axis=0).max())

    def check(self, nodes: Array) -> None:
        """Raise if the body with these nodes `(N, 3)` (m) has exploded.

        Raises:
            WorldError: a node is not finite, a tetrahedron is inverted or three times its volume, or the
                body has grown past twice its size.
        """
        if not np.isfinite(nodes).all():
            raise WorldError("the simulation exploded: a node of the mesh is not finite")
        ratio = tet_volumes(nodes, self._tetrahedra) / self._volumes
        if ratio.min() <= 0 or ratio.max() > 3 or np.ptp(nodes, axis=0).max() > 2 * self._size:
            raise WorldError(
                "the simulation exploded: volume ratios of tetrahedra run from "
                f"{ratio.min():.2g} to {ratio.max():.2g}; "
                "try a smaller world.engine.dt or a stiffer object"
            )
