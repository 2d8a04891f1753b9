"""Plane meshes of simple outlines: points along the rim and in the middle, joined by Delaunay triangles.

The rim's points lie about a cell apart on the outline, at its corners first. Inside they begin as a hexagonal
lattice along the principal axes and are relaxed: each moves to the centroid of the triangles around it (as in
Lloyd's method, IEEE Trans. Inf. Theory 28, 1982, with them in place of Voronoi cells). A side of the rim that
the triangulation lacks is halved until it is there (Ruppert, J. Algorithms 18, 1995): only where two parts of
the outline come nearer to each other than a cell. The same outline gives the same mesh, to the bit.
"""

from copy import copy
from dataclasses import dataclass

import numpy as np

from deformpush.mechanics.geometry import arc_length
from deformpush.mechanics.outline import SimpleOutline, contains, simple

Array = np.ndarray

MAX_CELLS = 200_000
"""Larger meshes are refused before they are built."""
_CORNER = np.radians(20)  # the outline turns by more than this within one cell
_APART = 0.7  # cells; corners nearer to each other are one, and so far from the rim points inside begin
_ROUNDS = 2  # of relaxing; more make no angle larger
_HALVINGS = 4  # of a side of the rim that another part of the outline is too near to


@dataclass(frozen=True)
class PlaneMesh:
    """Points and triangles of a plan."""

    points: Array
    """`(N, 2)` (m), those of the rim first."""
    triangles: Array
    """`(T, 3)` into the points, each counter-clockwise."""
    rim: int
    """So many points lie on the outline, in order, counter-clockwise."""

    @property
    def areas(self) -> Array:
        """Area (m^2) of each triangle `(T,)`."""
        return _areas(self.points, self.triangles)


def triangulate(outline: Array | SimpleOutline, cell: float) -> PlaneMesh:
    """Mesh an outline `(V, 2)` (m) with triangles of about `cell` (m) a side.

    Raises:
        ValueError: the outline is not simple (see `deformpush.mechanics.outline.simple`), the mesh would be
            too large, or two parts of the outline are too near to each other for cells of this size.
    """
    plan = outline if isinstance(outline, SimpleOutline) else simple(outline)
    refuse_too_many(triangles_in(plan.area, cell), cell)
    rim = _Rim(plan.points, cell)
    if len(rim.points) < 3:
        raise ValueError(
            f"cell: {cell:g} m is too large for an outline of {plan.area:.3g} m^2; make it smaller"
        )
    inner = _lattice(rim.points, cell)
    rim, inner, triangles = _joined(rim, inner)
    for _ in range(_ROUNDS):
        points = np.concatenate([rim.points, inner])
        inner = _centred(points, triangles)[len(rim.points) :]
        rim, inner, triangles = _joined(rim, inner)
    return PlaneMesh(np.concatenate([rim.points, inner]), triangles, len(rim.points))


def triangles_in(area: float, cell: float) -> float:
    """About how many triangles of this size (m) an area (m^2) takes."""
    return area / (np.sqrt(3) / 4 * cell**2)


def refuse_too_many(cells: float, cell: float) -> None:
    """Refuse a mesh of so many cells of this size (m) before it is built.

    Raises:
        ValueError: they are more than `MAX_CELLS`.
    """
    if cells > MAX_CELLS:
        raise ValueError(
            f"cell: {cell:g} m makes some {cells:.2g} cells, {MAX_CELLS} are allowed; enlarge it"
        )


class _Rim:
    """Points along an outline, each known by its arc length, so that more can be put between them."""

    def __init__(self, outline: Array, cell: float) -> None:
        self.cell, self.outline = cell, outline
        self._line = np.concatenate([outline, outline[:1]])
        self._along = arc_length(self._line)
        self._swept = np.append(0.0, np.cumsum(_cross(self._line[:-1], self._line[1:]) / 2))
        self.length = float(self._along[-1])
        self.corners = self._corners()
        self.at = self._spread()
        self.points = self._area_true()

    def halved(self, sides: Array) -> "_Rim":
        """The same with a point in the middle of each of these sides."""
        finer = copy(self)
        ends = np.append(self.at, self.at[0] + self.length)
        finer.at = np.sort(np.append(self.at, (ends[sides] + ends[sides + 1]) / 2 % self.length))
        finer.points = finer._area_true()
        return finer

    def _area_true(self) -> Array:
        """Points at the arc lengths, moved out where the outline bulges over the sides, in where it caves.

        Sides between points of a curve cut area off. So each point but the corners is moved along its normal
        until half of what its two sides cut off is back.
        """
        points, following = self._place(self.at), np.roll(self.at, -1)
        swept = np.interp(following, self._along, self._swept) - np.interp(self.at, self._along, self._swept)
        swept += np.where(following <= self.at, self._swept[-1], 0.0)  # past the outline's first point
        cut = swept - _cross(points, np.roll(points, -1, axis=0)) / 2
        chord = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
        length = np.linalg.norm(chord, axis=1)
        length[length == 0] = np.inf  # where the outline turns back on itself there is nowhere to move to
        out = np.stack([chord[:, 1], -chord[:, 0]], axis=1) / length[:, None]
        move = np.where(np.isin(self.at, self.corners), 0.0, (cut + np.roll(cut, 1)) / length)
        return points + move[:, None] * out

    def _spread(self) -> Array:
        """Arc lengths of the corners and of points between them, a cell apart as nearly as can be."""
        corners = self.corners if len(self.corners) else np.zeros(1)
        lengths = np.diff(np.append(corners, corners[0] + self.length))
        least = 3 if len(corners) == 1 else 1
        parts = np.maximum(least, np.round(lengths / self.cell)).astype(int)
        spread = [c + np.arange(n) * (s / n) for c, s, n in zip(corners, lengths, parts, strict=True)]
        return np.sort(np.concatenate(spread) % self.length)

    def _corners(self) -> Array:
        """Arc lengths of the outline's corners, the sharpest of those that lie near each other."""
        at, half = self._along[:-1], self.cell / 2
        to, on = self.outline - self._place(at - half), self._place(at + half) - self.outline
        turn = np.abs(np.arctan2(_cross(to, on), np.sum(to * on, axis=1)))
        kept: list[float] = []
        for i in np.argsort(-turn, kind="stable"):
            if turn[i] < _CORNER:
                break
            gap = np.abs(np.array(kept) - at[i])
            if np.all(np.minimum(gap, self.length - gap) >= _APART * self.cell):
                kept.append(float(at[i]))
        return np.sort(np.array(kept))

    def _place(self, at: Array) -> Array:
        """Points `(m, 2)` at these arc lengths."""
        return np.stack([np.interp(at % self.length, self._along, self._line[:, k]) for k in (0, 1)], axis=1)


def _lattice(rim: Array, cell: float) -> Array:
    """A hexagonal lattice inside the rim `(n, 2)` and clear of it, along the principal axes, `(m, 2)`."""
    from scipy.spatial import KDTree

    middle = rim.mean(axis=0)
    x, y = (rim - middle).T
    angle = np.arctan2(2 * np.sum(x * y), np.sum(x * x) - np.sum(y * y)) / 2
    c, s = np.cos(angle), np.sin(angle)
    reach = float(np.hypot(x, y).max())
    rows = np.arange(-np.ceil(reach / (cell * np.sqrt(0.75))), np.ceil(reach / (cell * np.sqrt(0.75))) + 1)
    columns = np.arange(-np.ceil(reach / cell), np.ceil(reach / cell) + 1)
    u = (columns + (rows[:, None] % 2) / 2) * cell
    v = np.broadcast_to(rows[:, None] * cell * np.sqrt(0.75), u.shape)
    lattice = middle + np.stack([c * u - s * v, s * u + c * v], axis=-1).reshape(-1, 2)
    lattice = lattice[contains(rim, lattice)]
    ends = np.roll(rim, -1, axis=0)
    dense = np.concatenate([rim + share * (ends - rim) for share in np.arange(8) / 8])
    distance, _ = KDTree(dense).query(lattice)
    return lattice[distance > _APART * cell]


def _joined(rim: _Rim, inner: Array) -> tuple[_Rim, Array, Array]:
    """Delaunay triangles of all points, and the points: halved or left out where a side was missing."""
    from scipy.spatial import Delaunay

    for _ in range(2 * _HALVINGS):
        points, n = np.concatenate([rim.points, inner]), len(rim.points)
        triangles = Delaunay(points).simplices.astype(np.int64)
        missing = _missing_sides(triangles, n)
        if not len(missing):
            return rim, inner, _inside(points, triangles, n)
        start, end = rim.points[missing], rim.points[(missing + 1) % n]
        away = np.linalg.norm(inner[:, None] - (start + end) / 2, axis=2)
        within = away < np.linalg.norm(end - start, axis=1) / 2 * (1 + 1e-9)
        inner = inner[~within.any(axis=1)]
        rim = rim.halved(missing[~within.any(axis=0)])
    gap = np.linalg.norm(end - start, axis=1).min()
    x, y = start[0]
    raise ValueError(
        f"cell: {rim.cell:g} m is too large where two parts of the outline come within {gap:.2g} m of each "
        f"other, near [{x:.3g}, {y:.3g}]; make it smaller, or the gap wider"
    )


def _missing_sides(triangles: Array, n: int) -> Array:
    """Sides i of the rim, from point i to the next, that are no side of a triangle."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    sides = np.sort(sides[np.all(sides < n, axis=1)], axis=1)
    rim = np.sort(np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1), axis=1)
    return np.flatnonzero(~np.isin(rim[:, 0] * n + rim[:, 1], sides[:, 0] * n + sides[:, 1]))


def _inside(points: Array, triangles: Array, n: int) -> Array:
    """Those triangles that lie inside the rim, the first n points; each turned counter-clockwise."""
    areas = _areas(points, triangles)
    turned = np.where((areas < 0)[:, None], triangles[:, [0, 2, 1]], triangles)
    keep = np.abs(areas) > 1e-9 * np.abs(areas).max()
    between = np.flatnonzero(keep & np.all(triangles < n, axis=1))  # others have a point that is inside
    keep[between] = contains(points[:n], points[triangles[between]].mean(axis=1))
    return turned[keep]


def _centred(points: Array, triangles: Array) -> Array:
    """The mean of the triangles around each point, weighted by their area `(N, 2)`."""
    areas = _areas(points, triangles)
    middles = points[triangles].mean(axis=1)
    corner = triangles.ravel()
    weight = np.bincount(corner, np.repeat(areas, 3), len(points))
    sums = [np.bincount(corner, np.repeat(areas * middles[:, k], 3), len(points)) for k in (0, 1)]
    return np.stack(sums, axis=1) / np.maximum(weight, 1e-300)[:, None]


def _areas(points: Array, triangles: Array) -> Array:
    """Signed areas (m^2) `(T,)`."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return _cross(b - a, c - a) / 2


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
