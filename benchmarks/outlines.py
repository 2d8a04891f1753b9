"""Eight outlines of 0.12 to 0.2 m, with the material of rect: what a benchmark of shapes pushes."""

import numpy as np

from tests.outlines import disc, ell, fish, kidney, rectangle, ring, star, tee

OUTLINES = {
    "ell": ell(),
    "tee": tee(),
    "ring": ring(),
    "kidney": kidney(points=60),
    "star": star(),
    "fish": fish(0.2, points=24),
    "round": disc(points=48),
    "square": rectangle(0.12, 0.12),
}
"""Counter-clockwise `(V, 2)` (m)."""
CELL = 0.0167
"""Three cells across an arm of the ell and the tee, and across the ring (m)."""
DENSITY = 500
"""That of rect: its mass over its volume (kg/m^3)."""


def settings(name: str) -> list[str]:
    """The overrides that make this outline the object of a run."""
    points = ",".join(f"[{x:.5f},{y:.5f}]" for x, y in np.asarray(OUTLINES[name]))
    return [
        "object=rect",
        f"object.outline=[{points}]",
        f"object.cell={CELL}",
        "object.material.mass=null",
        f"object.material.density={DENSITY}",
    ]
