"""Five functions of (u, k) whose minimum moves: u in the unit square, k the number of pushes made.

Each is drawn from a generator, spans a range of about 1 and is to be minimised. After dyn2d (Marchant et
al. 2014), parabola2d (Brunzema et al. 2022), moving peaks (Branke 1999), the Markov chain of TV-GP-UCB
(Bogunovic et al. 2016), and a jump.
"""

from collections.abc import Callable

import numpy as np

Problem = Callable[[np.ndarray, int], np.ndarray]
STEPS = 70
TICKS = np.linspace(0.0, 1.0, 101)
GRID = np.stack(np.meshgrid(TICKS, TICKS, indexing="ij"), axis=-1).reshape(-1, 2)


def dyn2d(rng: np.random.Generator) -> Problem:
    """A bump that circles once in 120 pushes."""
    phase = rng.random()

    def f(U: np.ndarray, k: int) -> np.ndarray:
        x, t = 5.0 * U, k / 120.0 + phase
        centre = 2.0 + 1.5 * np.array([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)])
        return -np.exp(-np.sum(((x - centre) / 0.7) ** 2, axis=1))

    return f


def parabola2d(rng: np.random.Generator) -> Problem:
    """A bowl that swings."""
    offset = rng.uniform(0.0, 60.0)

    def f(U: np.ndarray, k: int) -> np.ndarray:
        x, s, c = 14.0 * U - 7.0, np.sin(0.1 * (k + offset)), np.cos(0.1 * (k + offset))
        bowl = 4.0 * ((x[:, 0] / 4.0) ** 2 + (x[:, 1] / 4.0 - 0.5 * s) ** 2)
        return (bowl + 0.5 * x[:, 0] * s - c**2 + 5.0) / 30.0

    return f


def peaks2d(rng: np.random.Generator) -> Problem:
    """Five cones that wander, grow and shrink."""
    centres, heights, slopes = [rng.random((5, 2))], [rng.uniform(0.3, 1.0, 5)], [rng.uniform(1.5, 4.0, 5)]
    velocity = np.zeros((5, 2))
    for _ in range(STEPS):
        step = rng.normal(size=(5, 2))
        step = 0.5 * step / np.linalg.norm(step, axis=1, keepdims=True) * 0.02 + 0.5 * velocity
        velocity = 0.02 * step / np.linalg.norm(step, axis=1, keepdims=True)
        moved = centres[-1] + velocity
        out = (moved < 0) | (moved > 1)
        velocity[out] *= -1.0
        centres.append(np.clip(moved, 0.0, 1.0))
        heights.append(np.clip(heights[-1] + 0.03 * rng.normal(size=5), 0.3, 1.0))
        slopes.append(np.clip(slopes[-1] + 0.1 * rng.normal(size=5), 1.5, 4.0))

    def f(U: np.ndarray, k: int) -> np.ndarray:
        distance = np.linalg.norm(U[:, None] - centres[k], axis=2)
        return -np.maximum((heights[k] - slopes[k] * distance).max(axis=1), -0.2)

    return f


def tvgp(rng: np.random.Generator) -> Problem:
    """A Gaussian process that forgets 3 % of itself at every push; Matern 5/2, length scale 0.25."""
    a = np.sqrt(5.0) * np.abs(TICKS[:, None] - TICKS) / 0.25
    root = np.linalg.cholesky((1 + a + a * a / 3) * np.exp(-a) + 1e-9 * np.eye(101))

    def draw() -> np.ndarray:
        return root @ rng.normal(size=(101, 101)) @ root.T / 4.0

    fields = [draw()]
    for _ in range(STEPS):
        fields.append(np.sqrt(0.97) * fields[-1] + np.sqrt(0.03) * draw())

    def f(U: np.ndarray, k: int) -> np.ndarray:
        position = np.clip(U, 0.0, 1.0) * 100.0
        i = np.minimum(position.astype(int), 99)
        (a, b), field = (position - i).T, fields[k]
        i, j = i.T
        low = (1 - b) * field[i, j] + b * field[i, j + 1]
        return (1 - a) * low + a * ((1 - b) * field[i + 1, j] + b * field[i + 1, j + 1])

    return f


def jump2d(rng: np.random.Generator) -> Problem:
    """A bump that jumps at pushes 30 and 50."""
    centres = rng.uniform(0.1, 0.9, (3, 2))

    def f(U: np.ndarray, k: int) -> np.ndarray:
        centre = centres[int(k >= 30) + int(k >= 50)]
        return -np.exp(-np.sum(((U - centre) / 0.25) ** 2, axis=1))

    return f


PROBLEMS: dict[str, Callable[[np.random.Generator], Problem]] = {
    "dyn2d": dyn2d,
    "parabola2d": parabola2d,
    "peaks2d": peaks2d,
    "tvgp": tvgp,
    "jump2d": jump2d,
}
