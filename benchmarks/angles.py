"""The angle by registration of contours and by their principal axis: `python -m benchmarks.angles`.

Two pictures (1.5 mm a pixel) of each object, turned by any angle in between; and contours whose points are
0.5 mm off each.
"""

import argparse
from collections.abc import Callable

import numpy as np

from deformpush.config import build
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import principal_axis
from deformpush.mechanics.registration import ROUND, register, symmetry
from tests import pictures
from tests.outlines import OUTLINES, noisy

Array = np.ndarray

SHIPPED = ("rect", "meat", "fish_fillet", "pork", "tofu", "dough")
NOISE = 5e-4
"""Of each coordinate of each point (m)."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--pairs", type=int, default=200, help="pictures before and after a turn, each object"
    )
    pairs = parser.parse_args().pairs
    cfg = compose([])
    camera, perception = build.build(cfg.camera), build.build(cfg.contour)
    shapes = {name: build.build(compose([f"object={name}"]).object).polygon for name in SHIPPED} | OUTLINES
    print("| object | order | registration | principal axis | registration, noise | principal axis, noise |")
    print("|---|---|---|---|---|---|")
    for name, shape in shapes.items():
        rng = np.random.default_rng(0)

        def seen(turn: float, shift: Array, shape: Array = shape) -> Array:
            placed = pictures.placed(shape - shape.mean(axis=0), *(camera.centre + shift), np.degrees(turn))
            return perception.outline(pictures.picture(camera, placed)[..., 0] < 128, camera)

        def with_noise(
            turn: float, shift: Array, shape: Array = shape, rng: np.random.Generator = rng
        ) -> Array:
            return noisy(pictures.placed(shape, *shift, np.degrees(turn)), 128, NOISE, rng)

        order = symmetry(shape).order
        if order != ROUND:
            cells = [rms for look in (seen, with_noise) for rms in errors(look, order, pairs, rng)]
            print(f"| {name} | {order} | " + " | ".join(f"{cell:.2f}" for cell in cells) + " |", flush=True)


def errors(
    look: Callable[[float, Array], Array], order: int, pairs: int, rng: np.random.Generator
) -> tuple[float, float]:
    """Root mean square error (degrees) of registration and of the principal axis."""
    off: list[tuple[float, float]] = []
    for _ in range(pairs):
        first, turn = rng.uniform(-np.pi, np.pi, 2)
        before, after = look(first, np.zeros(2)), look(first + turn, rng.uniform(-0.05, 0.05, 2))
        axes = [principal_axis(contour - contour.mean(axis=0))[0] for contour in (before, after)]
        angle = register(before, after).angle
        assert angle is not None
        off.append((_error(angle - turn, order), _error(axes[1] - axes[0] - turn, 2)))
    registered, principal = np.sqrt(np.mean(np.square(off), axis=0))
    return float(registered), float(principal)


def _error(angle: float, order: int) -> float:
    step = 2 * np.pi / order
    return float(np.degrees((angle + step / 2) % step - step / 2))


if __name__ == "__main__":
    main()
