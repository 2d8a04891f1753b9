"""Accuracy gates: what the camera sees beside the mesh, and the arm's tip beside its commanded path."""

from collections.abc import Iterator, Sequence

import numpy as np

from deformpush.cell.cell import look, nearest_reachable
from deformpush.cell.perception import signed_area
from deformpush.checks.physics import Gate, centroid, rim
from deformpush.config.compose import compose
from deformpush.experiment.assemble import build_cell
from deformpush.worlds.bullet.world import BulletWorld

Pose = tuple[float, float, float]

POSES: tuple[Pose, ...] = (
    (0.58, 0.0, 0.0),
    (0.40, -0.15, 33.0),
    (0.72, 0.15, -70.0),
    (0.45, 0.20, 88.0),
    (0.75, -0.20, 10.0),
    (0.42, 0.0, -45.0),
)
"""x, y (m) and turn (degrees) of the object: the middle of the picture and places near its rim."""
KAPPAS = (0.05, 0.3, 0.45, 0.6, 0.75, 0.95)
"""Where the six pushes of the arm start along the effective contour."""


def gates(overrides: Sequence[str]) -> Iterator[Gate]:
    """Both gates for the cell that these settings describe; the robot is each gate's own."""
    others = [text for text in overrides if not text.startswith("robot=")]
    yield seen(others)
    yield tip(others)


def seen(overrides: Sequence[str], poses: Sequence[Pose] = POSES) -> Gate:
    """Area and centroid as a run perceives them, beside those of the mesh, the largest error of all poses."""
    areas, shifts = [], []
    for x, y, degrees in poses:
        place = [f"object.start=[{x},{y}]", f"object.start_deg={degrees}"]
        cell = build_cell(compose([*overrides, "robot=tool", *place]))
        assert isinstance(cell.world, BulletWorld), "doctor has refused any other"
        truth = rim(cell.world.mesh, cell.world.nodes())
        got, _, _ = look(cell, None)
        cell.world.close()
        areas.append(abs(signed_area(got.contour) / signed_area(truth) - 1))
        shifts.append(float(np.linalg.norm(got.c - centroid(truth))))
    return Gate(
        f"camera beside the mesh, {len(poses)} poses",
        f"area {max(areas):.1%}, centroid {max(shifts) * 1e3:.2f} mm",
        "area 2 %, centroid 1 mm",
        max(areas) <= 0.02 and max(shifts) <= 1e-3,
    )


def tip(overrides: Sequence[str], kappas: Sequence[float] = KAPPAS) -> Gate:
    """The longest push at several places, one after the other: how far the tip is from where it should be."""
    cfg = compose([*overrides, "robot=kuka_iiwa"])
    cell = build_cell(cfg)
    at, worst = None, 0.0
    for kappa in kappas:
        at, _, _ = look(cell, at)
        _, path = nearest_reachable(cell, np.array([kappa, cfg.object.d[1]]), at)
        worst = max(worst, cell.world.push(path).tip_error)
    cell.world.close()
    return Gate(
        f"arm's tip beside its path, {len(kappas)} pushes",
        f"{worst * 1e3:.2f} mm",
        "within 2 mm",
        worst <= 2e-3,
    )
