"""Outlines of objects, and random ones that nobody would draw."""

import numpy as np

from deformpush.mechanics.geometry import resample


def ell(size: float = 0.16, width: float = 0.05) -> np.ndarray:
    """An L whose arms are `width` wide."""
    a, w = size, width
    return np.array([(0, 0), (a, 0), (a, w), (w, w), (w, a), (0, a)]) - a / 3


def tee(size: float = 0.16, width: float = 0.05) -> np.ndarray:
    """A T as wide as high."""
    a, w = size / 2, width / 2
    bar = a - width
    return np.array([(-w, -a), (w, -a), (w, bar), (a, bar), (a, a), (-a, a), (-a, bar), (-w, bar)])


def ring(degrees: float = 270, inner: float = 0.05, outer: float = 0.1, points: int = 60) -> np.ndarray:
    """A sector of a ring."""
    angle = np.radians(np.linspace(0, degrees, points))
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.concatenate([outer * rim, inner * rim[::-1]])


def kidney(radius: float = 0.09, points: int = 100) -> np.ndarray:
    """A bean, bent so far that its middle lies outside."""
    angle = np.linspace(0, 2 * np.pi, points, endpoint=False)
    x, y = np.cos(angle), np.sin(angle)
    dent = np.exp(-((x / 0.5) ** 2)) * np.maximum(y, 0) ** 2
    return radius * np.column_stack([x, 0.55 * (y - dent) + 0.45 * x**2])


def star(tips: int = 5, outer: float = 0.1, inner: float = 0.045) -> np.ndarray:
    """A star with straight sides."""
    angle = np.pi / 2 + np.arange(2 * tips) * np.pi / tips
    r = np.where(np.arange(2 * tips) % 2 == 0, outer, inner)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle)])


def fish(length: float = 0.25, points: int = 40) -> np.ndarray:
    """A fish with its tail, nose to the left."""
    x = np.linspace(0, 0.8, points)
    belly = np.column_stack([x, -0.22 * np.sin(np.pi * (x * 1.075 + 0.02)) ** 0.8])
    tail = [(0.88, -0.1), (1.0, -0.2), (0.95, 0.0), (1.0, 0.2), (0.88, 0.1)]
    return length * (np.concatenate([belly, tail, belly[::-1] * (1, -1)]) - (0.5, 0))


def disc(radius: float = 0.07, points: int = 90) -> np.ndarray:
    """A disc, as a regular polygon."""
    angle = np.linspace(0, 2 * np.pi, points, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def rectangle(width: float = 0.2, height: float = 0.1) -> np.ndarray:
    """A rectangle about the origin."""
    return np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (width / 2, height / 2)


OUTLINES = {
    "rect": rectangle(),
    "square": rectangle(0.12, 0.12),
    "disc": disc(),
    "ell": ell(),
    "thin ell": ell(0.2, 0.02),
    "tee": tee(),
    "ring": ring(),
    "kidney": kidney(),
    "star": star(),
    "fish": fish(),
}
"""Every one about 0.12 to 0.25 m long, counter-clockwise."""


def noisy(outline: np.ndarray, points: int, noise: float, rng: np.random.Generator) -> np.ndarray:
    """The outline as evenly spaced points that are each a little off (m), from anywhere along it."""
    contour = resample(np.roll(resample(outline, 1024), int(rng.integers(1024)), axis=0), points)
    return contour + rng.normal(0, noise, contour.shape)


def spiky(rng: np.random.Generator) -> np.ndarray:
    """Star-shaped about the origin, and as rough as can be."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(5, 40)))
    r = 0.1 * rng.uniform(0.3, 1, len(angle))
    return np.column_stack([r * np.cos(angle), r * np.sin(angle)])


def random_walk(rng: np.random.Generator) -> np.ndarray:
    """A closed walk, untangled: sides are exchanged as long as that makes it shorter."""
    walk = np.cumsum(rng.normal(0, 0.05, (rng.integers(4, 13), 2)), axis=0)
    n = len(walk)
    shorter = True
    while shorter:
        shorter = False
        for i in range(n - 1):
            for j in range(i + 2, n - (i == 0)):
                a, b, c, d = walk[i], walk[i + 1], walk[j], walk[(j + 1) % n]
                was = np.hypot(*(b - a)) + np.hypot(*(d - c))
                if np.hypot(*(c - a)) + np.hypot(*(d - b)) < was - 1e-12:
                    walk[i + 1 : j + 1] = walk[i + 1 : j + 1][::-1].copy()
                    shorter = True
    return walk


def comb(rng: np.random.Generator) -> np.ndarray:
    """Teeth beside each other, the gaps down to half a millimetre."""
    tooth, gap, length, back = rng.uniform((0.004, 0.0005, 0.02, 0.005), (0.03, 0.03, 0.15, 0.03))
    left = np.arange(rng.integers(2, 12)) * (tooth + gap)
    x = np.column_stack([left, left, left + tooth, left + tooth]).ravel()
    y = np.tile([0, length, length, 0], len(left))
    return np.concatenate([[(x[-1], -back), (0, -back)], np.column_stack([x, y])])[::-1]


def spiral(rng: np.random.Generator) -> np.ndarray:
    """A band rolled up one to three times."""
    angle = np.linspace(0.5, 2 * np.pi * rng.uniform(1, 3), 200)
    pitch = rng.uniform(0.01, 0.03)
    half = pitch * rng.uniform(0.1, 0.4)
    r = pitch * angle / (2 * np.pi) + 0.01
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.concatenate([(r + half)[:, None] * rim, ((r - half)[:, None] * rim)[::-1]])


RANDOM = {"spiky": spiky, "random walk": random_walk, "comb": comb, "spiral": spiral}
