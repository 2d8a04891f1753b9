"""A soft sheet in the plane: elastic energy, dry friction on a table, contact with a disc; many at once.

Energies are over mu m g, the friction of the whole sheet, so they are lengths (m). One number says how stiff
a sheet is against its friction: e = E h sqrt(A) / (mu m g), of Young's modulus E, thickness h and area A. The
elastic law is corotated, in plane stress: psi = m |F - R|^2 + l / 2 (tr(R'F) - 2)^2. Its rotation R has a
closed form in the plane, and its second derivative is made positive (Smith, de Goes and Kim, ACM Trans.
Graph. 38, 2019). Friction is smoothed: less than `CREEP` of motion meets less than the whole of it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from deformpush.mechanics.triangulation import PlaneMesh

Array = np.ndarray

CREEP = 1.5e-4
"""Motion (m) at which friction has 0.7 of its full size."""
HARD = 2e4
"""Force (of mu m g) with which each place of the rim resists the tool, over its depth in the disc (1/m)."""
SAMPLES = 4
"""Places on each side of the rim that the tool may touch."""
_TINY = 1e-12
_ENDS = np.stack([1 - (np.arange(SAMPLES) + 0.5) / SAMPLES, (np.arange(SAMPLES) + 0.5) / SAMPLES], axis=1)
"""What each end of a side counts at its places `(SAMPLES, 2)`."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A sheet at rest. Nodes are numbered so that neighbours are near to each other."""

    rest: Array
    """`(N, 2)` (m)."""
    triangles: Array
    """`(T, 3)`, counter-clockwise."""
    rim: Array
    """Nodes along the outline `(B,)`, counter-clockwise."""
    load: Array
    """Share of the weight on each node `(N,)`; they add up to 1."""
    e: float
    """E h sqrt(A) / (mu m g) (-)."""
    nu: float = 0.35
    """Poisson's ratio (-)."""

    @classmethod
    def of(cls, mesh: PlaneMesh, e: float, nu: float = 0.35, rim_share: float = 0.0) -> "Sheet":
        """A sheet of a plane mesh, its weight spread by area, `rim_share` of it over the nodes of the rim."""
        t, n = mesh.triangles, len(mesh.points)
        graph = csr_matrix((np.ones(t.size), (t.ravel(), np.roll(t, 1, axis=1).ravel())), (n, n))
        order = np.asarray(reverse_cuthill_mckee(graph + graph.T, symmetric_mode=True))
        number = np.empty(n, int)
        number[order] = np.arange(n)
        areas = mesh.areas
        load = np.bincount(t.ravel(), np.repeat(areas, 3), n) / (3 * areas.sum()) * (1 - rim_share)
        load[: mesh.rim] += rim_share / mesh.rim
        return cls(mesh.points[order], number[t], number[np.arange(mesh.rim)], load[order], e, nu)

    @cached_property
    def area(self) -> Array:
        """Of each triangle at rest `(T,)` (m^2)."""
        return _cross(*self._edges) / 2

    @cached_property
    def gradients(self) -> Array:
        """Of the three shape functions of each triangle `(T, 3, 2)` (1/m)."""
        u, v = self._edges
        twice = (2 * self.area)[:, None]
        g1, g2 = np.stack([v[:, 1], -v[:, 0]], 1) / twice, np.stack([-u[:, 1], u[:, 0]], 1) / twice
        return np.stack([-g1 - g2, g1, g2], axis=1)

    @property
    def lame(self) -> tuple[float, float]:
        """The constants m and l of the law (1/m), for plane stress."""
        stiffness = self.e / np.sqrt(self.area.sum())
        return stiffness / (2 * (1 + self.nu)), stiffness * self.nu / (1 - self.nu**2)

    @property
    def bandwidth(self) -> int:
        """Of a matrix over all coordinates: so many diagonals below the main one."""
        return 2 * int(np.ptp(self.triangles, axis=1).max()) + 1

    def stretch(self, x: Array) -> Array:
        """Deformation gradients F `(n, T, 2, 2)` of positions `(n, N, 2)`."""
        return np.asarray(np.swapaxes(x[:, self.triangles], 2, 3) @ self.gradients)

    def strain(self, x: Array) -> Array:
        """Largest principal engineering strain, as a size, in each triangle `(n, T)`."""
        return np.asarray(np.abs(np.linalg.svd(self.stretch(x), compute_uv=False) - 1).max(axis=-1))

    def elastic(self, x: Array) -> Array:
        """Elastic energy `(n,)` at positions `(n, N, 2)`."""
        m, lam = self.lame
        f = self.stretch(x)
        s, _ = _rotation(f)
        psi = m * (np.sum(f**2, axis=(2, 3)) - 2 * s + 2) + lam / 2 * (s - 2) ** 2
        return np.asarray(psi @ self.area)

    def elastic_forces(self, x: Array) -> tuple[Array, Array]:
        """Slope of the elastic energy `(n, N, 2)`, and its positive second derivative `(n, T, 6, 6)`."""
        m, lam = self.lame
        f = self.stretch(x)
        s, r = _rotation(f)
        along = lam * (s - 2) - 2 * m
        stress = (2 * m * f + along[..., None, None] * r) * self.area[:, None, None]
        v = self.gradients @ np.swapaxes(r, 2, 3)
        w = np.stack([-v[..., 1], v[..., 0]], axis=-1).reshape(*f.shape[:2], 6)
        v, turn = v.reshape(*f.shape[:2], 6), np.maximum(along / np.maximum(s, _TINY), -m)
        second = lam * v[..., :, None] * v[..., None, :]
        second += turn[..., None, None] * w[..., :, None] * w[..., None, :]
        second += 2 * m * self._products
        second *= self.area[:, None, None]
        return self.on_nodes(self.gradients @ np.swapaxes(stress, 2, 3), self.triangles), second

    def friction(self, x: Array, was: Array) -> Array:
        """Energy `(n,)` of sliding from `was` to `x` `(n, N, 2)`."""
        return np.asarray((_slid(x - was) - CREEP) @ self.load)

    def friction_forces(self, x: Array, was: Array) -> tuple[Array, Array]:
        """Its slope `(n, N, 2)` and second derivative `(n, N, 2, 2)`."""
        size = _slid(x - was)[..., None]
        slope, load = (x - was) / size, self.load[:, None]
        second = (np.eye(2) - slope[..., :, None] * slope[..., None, :]) * (load / size)[..., None]
        return slope * load, second

    def contact(self, x: Array, tool: Array, radius: float) -> Array:
        """Energy `(n,)` of the rim in discs at `tool` `(n, 2)`."""
        depth = np.maximum(radius - np.sqrt(np.sum(self._from_tool(x, tool) ** 2, axis=3)), 0.0)
        return np.asarray(HARD / 2 * np.sum(depth**2, axis=(1, 2)))

    def contact_forces(self, x: Array, tool: Array, radius: float) -> tuple[Array, Array]:
        """Its slope `(n, N, 2)` and second derivative `(n, B, 4, 4)` over the two ends of each side."""
        off = self._from_tool(x, tool)
        distance = np.sqrt(np.sum(off**2, axis=3))
        depth = np.maximum(radius - distance, 0.0)
        normal = off / np.maximum(distance, _TINY)[..., None]
        pressed = _ENDS.T @ (-HARD * depth[..., None] * normal)
        lever = (_ENDS[:, :, None] * normal[..., None, :]).reshape(*depth.shape, 4) * (depth > 0)[..., None]
        return self.on_nodes(pressed, self.sides), HARD * (np.swapaxes(lever, 2, 3) @ lever)

    def on_nodes(self, values: Array, nodes: Array) -> Array:
        """Sums `(n, N, 2)` of values `(n, G, k, 2)` at the nodes `(G, k)` they belong to."""
        n = len(values)
        summed = self._gather[nodes.shape] @ values.reshape(n, -1, 2).transpose(1, 0, 2).reshape(-1, 2 * n)
        return np.asarray(summed).reshape(-1, n, 2).transpose(1, 0, 2)

    @cached_property
    def sides(self) -> Array:
        """Nodes at the ends of each side of the rim `(B, 2)`."""
        return np.stack([self.rim, np.roll(self.rim, -1)], axis=1)

    def _from_tool(self, x: Array, tool: Array) -> Array:
        """Where the places on each side lie, seen from the tools `(n, B, SAMPLES, 2)`."""
        return np.asarray(_ENDS @ (x[:, self.sides] - tool[:, None, None]))

    @cached_property
    def _products(self) -> Array:
        """Of the gradients, for each pair of coordinates of a triangle `(T, 6, 6)`."""
        return np.kron(self.gradients @ np.swapaxes(self.gradients, 1, 2), np.eye(2))

    @cached_property
    def _gather(self) -> dict[tuple[int, ...], csr_matrix]:
        return {nodes.shape: _sums(nodes.ravel(), len(self.rest)) for nodes in (self.triangles, self.sides)}

    @property
    def _edges(self) -> tuple[Array, Array]:
        a, b, c = (self.rest[self.triangles[:, k]] for k in range(3))
        return b - a, c - a


def _rotation(f: Array) -> tuple[Array, Array]:
    """tr(R'F) and R, the rotation nearest to F `(..., 2, 2)`."""
    a, b = f[..., 0, 0] + f[..., 1, 1], f[..., 1, 0] - f[..., 0, 1]
    s = np.sqrt(a * a + b * b)
    c, d = a / np.maximum(s, _TINY), b / np.maximum(s, _TINY)
    return s, np.stack([np.stack([c, -d], axis=-1), np.stack([d, c], axis=-1)], axis=-2)


def _slid(way: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(way**2, axis=2) + CREEP**2))


def _sums(rows: Array, n: int) -> csr_matrix:
    """The matrix `(n, len(rows))` that adds up values by row."""
    return csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), (n, len(rows)))


def _cross(u: Array, v: Array) -> Array:
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
