"""Strain of a tetrahedral mesh: deformation gradient, principal stretches, and a body's strain summed up.

The strain that is summed up and compared with an object's limit is the largest principal engineering strain,

    s = max_i |lambda_i - 1|,

with lambda_i the principal stretches: the largest relative change of length of any fibre of the material, be
it longer or shorter. Limits of food in the literature are what a test machine reads when a sample breaks, a
change of length over a length, in tension or in compression; this is the same number in any direction, and
turning the body does not change it. Stress and energy are in `deformpush.mechanics.neo_hookean`; sources
seldom state limits in them.

The strain of a linear tetrahedron is constant in it. The largest of all depends on mesh and time step, so
aggregates over the volume are kept beside it, and the limit is held against `p99`.
"""

from dataclasses import dataclass

import numpy as np

from deformpush.mechanics.mesh import TetMesh
from deformpush.mechanics.rounding import STRAINS, rounded

Array = np.ndarray

MOST_STRAINED = 0.1
"""Share of the volume that `top10` is the mean of."""
BATCH = 32
"""Samples that a gauge evaluates together: few calls of numpy, little memory."""


@dataclass(frozen=True)
class Aggregates:
    """One body's strain in three numbers (-)."""

    p99: float
    """99 % of the volume is strained no more than this."""
    top10: float
    """Mean over the most strained tenth of the volume."""
    maximum: float


class RestShape:
    """The undeformed mesh, ready to be compared with deformed ones."""

    def __init__(self, mesh: TetMesh) -> None:
        self.tetrahedra, self.volumes = mesh.tetrahedra, mesh.volumes
        self.nodes = len(mesh.nodes)
        self._inverse = np.linalg.inv(np.stack(_edges(mesh.nodes, mesh.tetrahedra), axis=-1))

    def gradients(self, nodes: Array) -> Array:
        """Deformation gradients F = Ds Dm^-1 `(..., T, 3, 3)` of nodes `(..., N, 3)`.

        Each of the nine components lies contiguous in memory: sums over many tetrahedra are then quick.
        """
        sides = [np.moveaxis(edge, -1, 0) for edge in _edges(nodes, self.tetrahedra)]
        columns = [sum(sides[k] * self._inverse[:, k, j] for k in range(3)) for j in range(3)]
        return np.moveaxis(np.stack(columns, axis=1), (0, 1), (-2, -1))

    def strain(self, nodes: Array) -> Array:
        """Strain s of each tetrahedron `(..., T)` of nodes `(..., N, 3)`."""
        return strain(self.gradients(nodes))

    def at_nodes(self, strain: Array) -> Array:
        """Strain `(N,)` of the most strained tetrahedron `(T,)` at each node: a picture hides no peak."""
        worst = np.zeros(self.nodes)
        np.maximum.at(worst, self.tetrahedra, strain[:, None])
        return worst

    def aggregates(self, strain: Array) -> Aggregates:
        """Sum up the strain of all tetrahedra `(T,)`; of samples `(S, T)` the largest of each aggregate."""
        ordered, share = _by_size(np.atleast_2d(strain), self.volumes)
        upper = np.cumsum(share, axis=1)
        rank = np.argmax(upper > 0.99 - 1e-9, axis=1)
        p99 = float(ordered[np.arange(len(rank)), rank].max())
        part = np.clip(upper - (1 - MOST_STRAINED), 0.0, share)
        top10 = float(np.max(np.sum(part * ordered, axis=1) / np.sum(part, axis=1)))
        return Aggregates(*rounded(np.array([p99, top10, ordered[:, -1].max()]), STRAINS).tolist())


class Gauge:
    """Peak over time of each aggregate and of each tetrahedron, over all the samples it is shown."""

    def __init__(self, rest: RestShape) -> None:
        self._rest = rest
        self._waiting: list[Array] = []
        self._seen: list[Aggregates] = []
        self._worst = np.zeros(len(rest.tetrahedra))

    def look(self, nodes: Array) -> None:
        """Take a sample `(N, 3)`."""
        self._waiting.append(nodes)
        if len(self._waiting) == BATCH:
            self._evaluate()

    def peak(self) -> Aggregates:
        """The largest of each aggregate so far.

        Raises:
            ValueError: there was no sample.
        """
        self._evaluate()
        if not self._seen:
            raise ValueError("no sample of the mesh: nothing has a strain")
        rows = [(one.p99, one.top10, one.maximum) for one in self._seen]
        return Aggregates(*np.max(rows, axis=0).tolist())

    def field(self) -> Array:
        """The largest strain of each tetrahedron so far `(T,)`; 0 without a sample."""
        self._evaluate()
        return self._worst

    def _evaluate(self) -> None:
        if not self._waiting:
            return
        strain = self._rest.strain(np.stack(self._waiting))
        self._worst = np.maximum(self._worst, strain.max(axis=0))
        self._seen.append(self._rest.aggregates(strain))
        self._waiting.clear()


def green(F: Array) -> Array:
    """Green strain E = (F'F - I) / 2 `(..., 3, 3)`."""
    E = np.empty((3, 3, *F.shape[:-2]))
    for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)):
        E[i, j] = E[j, i] = (sum(F[..., k, i] * F[..., k, j] for k in range(3)) - (i == j)) / 2
    return np.moveaxis(E, (0, 1), (-2, -1))


def stretches(F: Array) -> Array:
    """Principal stretches `(..., 3)`, the largest first."""
    return _elongations(F) + 1


def strain(F: Array) -> Array:
    """Largest principal engineering strain max |lambda_i - 1| `(...)`.

    A rotation gives zero but for rounding: no more than 2e-15 for a rotation matrix (whose own entries are
    rounded), some 1e-14 for a turned mesh (coordinates rounded to 1e-16 m, over cells of 0.01 m).
    """
    return np.asarray(np.abs(_elongations(F)[..., [0, 2]]).max(axis=-1))


def _elongations(F: Array) -> Array:
    """lambda_i - 1, without the loss of digits that subtracting 1 from lambda_i would bring."""
    e = symmetric_eigenvalues(green(F))
    return np.asarray(2 * e / (np.sqrt(np.maximum(1 + 2 * e, 0.0)) + 1))


def symmetric_eigenvalues(A: Array) -> Array:
    """Eigenvalues of symmetric matrices `(..., 3, 3)`, the largest first, exact to rounding.

    The trigonometric solution of the characteristic cubic, faster than LAPACK on many small matrices. With
    s the deviator of A, J2 = s:s / 2 and J3 = det s, the eigenvalues are
    tr A / 3 + 2 sqrt(J2 / 3) cos(phi + 2 pi k / 3), cos(3 phi) = sqrt(27) J3 / (2 J2^1.5). Near a double
    eigenvalue the arc cosine would lose half of the digits. Its sine does not: 4 J2^3 - 27 J3^2 is the Gram
    determinant of I, s and s^2, hence 3 (s:s) (t:t) with t the part of s^2 orthogonal to I and s.
    """
    mean = np.trace(A, axis1=-2, axis2=-1) / 3
    xx, yy, zz = (A[..., i, i] - mean for i in range(3))
    yz, xz, xy = A[..., 1, 2], A[..., 0, 2], A[..., 0, 1]
    # Matrices scaled to size 1: a square of a tiny strain must not vanish.
    size = np.sqrt(xx**2 + yy**2 + zz**2 + 2 * (yz**2 + xz**2 + xy**2))
    scale = 1 / np.where(size > 0, size, 1.0)
    xx, yy, zz, yz, xz, xy = (part * scale for part in (xx, yy, zz, yz, xz, xy))
    det = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    # tr(s^3) = 3 det s for a deviator, and s:s = 1 now: t = s^2 - I / 3 - 3 det s.
    along = 3 * det
    txx = xx**2 + xy**2 + xz**2 - 1 / 3 - along * xx
    tyy = xy**2 + yy**2 + yz**2 - 1 / 3 - along * yy
    tzz = xz**2 + yz**2 + zz**2 - 1 / 3 - along * zz
    tyz = xy * xz + yz * (yy + zz) - along * yz
    txz = xy * yz + xz * (xx + zz) - along * xz
    txy = xz * yz + xy * (xx + yy) - along * xy
    gram = 3 * (txx**2 + tyy**2 + tzz**2 + 2 * (tyz**2 + txz**2 + txy**2))
    phi = np.arctan2(np.sqrt(gram), np.sqrt(27) * det) / 3
    turns = phi[..., None] + 2 * np.pi / 3 * np.array([0, -1, 1])
    return np.asarray(mean[..., None] + (size * np.sqrt(2 / 3))[..., None] * np.cos(turns))


def _edges(nodes: Array, tetrahedra: Array) -> list[Array]:
    """The edges b - a, c - a, d - a, each `(..., T, 3)`; each coordinate contiguous."""
    a, b, c, d = (np.moveaxis(np.moveaxis(nodes, -1, 0)[..., corner], 0, -1) for corner in tetrahedra.T)
    return [b - a, c - a, d - a]


def _by_size(strain: Array, volumes: Array) -> tuple[Array, Array]:
    """Strain `(S, T)` from small to large, and the share of the volume `(S, T)` that has it."""
    order = np.argsort(strain, axis=1)
    return np.take_along_axis(strain, order, axis=1), (volumes / volumes.sum())[order]
