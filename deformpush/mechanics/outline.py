"""Checks of an outline before it is meshed: size, orientation, crossings; and how thin it is.

An outline is a polygon `(V, 2)` in metres, closed by itself. It is simple if it meets itself nowhere.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from deformpush.mechanics.geometry import signed_area, wrap

Array = np.ndarray

SIZE = (0.02, 1.0)
"""Longer side of the bounding box that an object may have (m)."""
MAX_POINTS = 2000
"""More points than that are pixels of a picture, not an outline."""
SAME = 1e-9
"""Points nearer to each other than this are one (m)."""
_PAIRS = 1_000_000  # pairs of sides, or of points and sides, that are looked at together: some 100 MB
_ROUND_A_TIP = 4.0  # way from one end of a width round to the other, over the width: shorter round a corner
_PARALLEL = np.radians(12)


@dataclass(frozen=True)
class SimpleOutline:
    """A polygon that can be meshed."""

    points: Array
    """`(V, 2)` (m), counter-clockwise, no point twice in a row."""
    reversed: bool
    """Whether it was given clockwise."""

    @property
    def area(self) -> float:
        """Area (m^2)."""
        return signed_area(self.points)


def simple(outline: Array) -> SimpleOutline:
    """Check an outline `(V, 2)` (m), drop points given twice in a row, and turn it counter-clockwise.

    Raises:
        ValueError: there is no area, a number is not finite, it is no object's size, it has more than
            `MAX_POINTS` points, or it meets itself.
    """
    points = np.array(outline, float)
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"outline: must be points [x, y], not of shape {list(points.shape)}")
    if not np.isfinite(points).all():
        raise ValueError("outline: a coordinate is not a finite number")
    if len(points) > MAX_POINTS:
        raise ValueError(f"outline: has {len(points)} points; simplify it to {MAX_POINTS} or fewer")
    lo, hi = points.min(axis=0), points.max(axis=0)
    if not np.all(hi > lo):
        raise ValueError(f"outline: covers no area, it reaches from {lo.tolist()} to {hi.tolist()}")
    size = float((hi - lo).max())
    if not SIZE[0] <= size <= SIZE[1]:
        hint = "; are they millimetres? Divide by 1000" if SIZE[0] <= size / 1000 <= SIZE[1] else ""
        raise ValueError(
            f"outline: is {size:g} m long, must be {SIZE[0]:g} to {SIZE[1]:g} m; "
            f"its points are in metres{hint}"
        )
    points = points[np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1) > SAME]
    met = _meeting(points) if len(points) > 2 else None
    if met is not None:
        i, j = met
        x, y = points[j]
        raise ValueError(
            f"outline: crosses or touches itself, sides {i} and {j} meet near [{x:.4g}, {y:.4g}]; "
            "order its points along the rim and leave room between its parts"
        )
    area = signed_area(points)
    if abs(area) <= SAME * size:
        raise ValueError(f"outline: covers no area, it reaches from {lo.tolist()} to {hi.tolist()}")
    return SimpleOutline(points[::-1] if area < 0 else points, area < 0)


def contains(polygon: Array, points: Array) -> Array:
    """Which points `(P, 2)` lie inside a polygon `(V, 2)`, by crossings of a ray: bool `(P,)`."""
    inside = np.zeros(len(points), bool)
    a, b = polygon, np.roll(polygon, -1, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    for part in _blocks(len(points), len(polygon)):
        x, y = points[part, 0, None], points[part, 1, None]
        crossed = (a[:, 1] > y) != (b[:, 1] > y)
        with np.errstate(invalid="ignore"):
            left = x < a[:, 0] + (y - a[:, 1]) * slope
        inside[part] = np.count_nonzero(crossed & left, axis=1) % 2 == 1
    return inside


def neck(outline: Array, step: float) -> float:
    """Width (m) of a simple outline `(V, 2)` where it is thinnest.

    A width is the distance of two places that face each other across the inside: an edge of the Delaunay
    triangulation of points along the outline whose ends lie on parallel sides, or at corners between them. A
    corner tapers to nothing and is no neck: its sides are not parallel, and the way round it is short.

    Args:
        outline: counter-clockwise.
        step: distance of the points along it that are looked at (m); a width of four steps is right to 1 %.
    """
    from scipy.spatial import Delaunay  # heavy: only where something is meshed

    points, s, direction, turn = _dense(outline, step)
    triangles = Delaunay(points).simplices
    triangles = triangles[contains(outline, points[triangles].mean(axis=1))]
    i, j = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).T
    width = np.linalg.norm(points[i] - points[j], axis=1)
    way = np.abs(s[i] - s[j])
    far = np.minimum(way, s[-1] - way) >= _ROUND_A_TIP * width
    askew = np.abs(wrap(direction[i] - direction[j] + np.pi))
    necks = far & (askew <= turn[i] + turn[j] + _PARALLEL)
    inradius = _inradius(outline, points[triangles])  # a compact body is as thin as the largest disc in it
    return float(min(width[necks].min(initial=np.inf), 2 * inradius))


def _dense(outline: Array, step: float) -> tuple[Array, Array, Array, Array]:
    """All corners and points between them, at most `step` apart.

    Returns:
        Points `(n, 2)`; their arc lengths, and the whole length last `(n + 1,)`; the mean direction of the
        sides that meet there `(n,)` (rad), and by how much each is turned from that `(n,)`.
    """
    side = np.roll(outline, -1, axis=0) - outline
    length = np.linalg.norm(side, axis=1)
    parts = np.maximum(1, np.ceil(length / step)).astype(int)
    of = np.repeat(np.arange(len(outline)), parts)
    share = (np.arange(len(of)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[of]
    s = np.append((np.cumsum(length) - length)[of] + share * length[of], length.sum())
    along = np.arctan2(side[:, 1], side[:, 0])[of]
    half = np.where(share == 0, wrap(along - np.roll(along, 1)) / 2, 0.0)
    return outline[of] + share[:, None] * side[of], s, along - half, np.abs(half)


def _inradius(outline: Array, corners: Array) -> float:
    """Radius of the largest disc in an outline: a circle through the corners of triangles `(T, 3, 2)`."""
    a, b, c = (corners[:, k] for k in range(3))
    u, v = b - a, c - a
    twice = _cross(u, v)
    real = twice > SAME**2
    a, u, v, twice = a[real], u[real], v[real], twice[real, None]
    uu, vv = np.sum(u**2, axis=1)[:, None], np.sum(v**2, axis=1)[:, None]
    middle = np.stack([uu * v[:, 1:] - vv * u[:, 1:], vv * u[:, :1] - uu * v[:, :1]], axis=1)[..., 0] / (
        2 * twice
    )
    inside = contains(outline, a + middle)
    return float(np.linalg.norm(middle[inside], axis=1).max(initial=0.0))


def _meeting(p: Array) -> tuple[int, int] | None:
    """Two sides of a polygon that cross, touch or fold back on each other, or None.

    Sides are sorted along one axis; only those whose ranges overlap there are compared.
    """
    a, b = p, np.roll(p, -1, axis=0)
    back = np.roll(b, -1, axis=0) - b
    folded = np.flatnonzero((_cross(b - a, back) == 0) & (np.sum((b - a) * back, axis=1) < 0))
    if len(folded):
        return int(folded[0]), int((folded[0] + 1) % len(p))
    lo, hi = np.minimum(a, b), np.maximum(a, b)
    sweeps = [_overlapping(lo[:, axis], hi[:, axis]) for axis in (0, 1)]
    order, count = min(sweeps, key=lambda sweep: int(sweep[1].sum()))
    for first, second in _pairs(order, count):
        gap = np.abs(first - second)
        near = (gap > 1) & (gap < len(p) - 1)
        near &= np.all((lo[first] <= hi[second]) & (lo[second] <= hi[first]), axis=1)
        i, j = first[near], second[near]
        apart = _side(a[i], b[i], a[j]) * _side(a[i], b[i], b[j]) > 0
        apart |= _side(a[j], b[j], a[i]) * _side(a[j], b[j], b[i]) > 0
        if not apart.all():
            met = int(np.argmin(apart))
            return int(min(i[met], j[met])), int(max(i[met], j[met]))
    return None


def _overlapping(lo: Array, hi: Array) -> tuple[Array, Array]:
    """Intervals in the order of their lower ends, and how many later ones each overlaps."""
    order = np.argsort(lo, kind="stable")
    last = np.searchsorted(lo[order], hi[order], side="right")
    return order, last - np.arange(len(lo)) - 1


def _pairs(order: Array, count: Array) -> Iterator[tuple[Array, Array]]:
    """Pairs of an entry of `order` and each of the `count` entries behind it, in blocks."""
    block = np.cumsum(count) // _PAIRS
    for k in np.unique(block):
        row = np.flatnonzero(block == k)
        n = count[row]
        of = np.repeat(row, n)
        yield order[of], order[of + 1 + np.arange(len(of)) - np.repeat(np.cumsum(n) - n, n)]


def _blocks(rows: int, columns: int) -> Iterator[slice]:
    """Slices of so many rows that a table of them with these columns stays small."""
    size = max(1, _PAIRS // columns)
    return (slice(k, k + size) for k in range(0, rows, size))


def _side(a: Array, b: Array, p: Array) -> Array:
    """On which side of the line from a to b points p lie: 1 left, -1 right, 0 on it."""
    return np.sign(_cross(b - a, p - a))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
