"""Accuracy gates: what the camera sees beside the mesh, and the arm's tip beside its commanded path."""

from collections.abc import Iterator, Sequence

import numpy as np

from deformpush.checks.gate import Gate
from deformpush.checks.physics import rim
from deformpush.config.compose import compose
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.setup import read
from deformpush.mechanics.geometry import resample, signed_area
from deformpush.worlds.finite_elements import FiniteElementWorld

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
        cell = build_cell(read(compose([*overrides, "robot=tool", *place])))
        assert isinstance(cell.world, FiniteElementWorld), "only these have such gates"
        truth = rim(cell.world.mesh, cell.world.nodes())
        got = cell.look(None)[0].seen
        cell.world.close()
        areas.append(abs(signed_area(got.contour) / signed_area(truth) - 1))
        # A run's centroid is the mean of evenly spaced contour points, which is not that of the area.
        shifts.append(float(np.linalg.norm(got.c - resample(truth, len(got.contour)).mean(axis=0))))
    return Gate(
        f"camera beside the mesh, {len(poses)} poses",
        f"area {max(areas):.1%}, centroid {max(shifts) * 1e3:.2f} mm",
        "area 2 %, centroid 1 mm",
        max(areas) <= 0.02 and max(shifts) <= 1e-3,
    )


def tip(overrides: Sequence[str], kappas: Sequence[float] = KAPPAS) -> Gate:
    """The longest push at several places, one after the other: how far the tip is from where it should be."""
    setup = read(compose([*overrides, "robot=kuka_iiwa"]))
    cell = build_cell(setup)
    at, worst = None, 0.0
    for kappa in kappas:
        at = cell.look(at)[0].seen
        _, path = cell.reachable(np.array([kappa, setup.object.d[1]]), at)
        worst = max(worst, cell.world.push(path).tip_error)
    cell.world.close()
    return Gate(
        f"arm's tip beside its path, {len(kappas)} pushes",
        f"{worst * 1e3:.2f} mm",
        "within 2 mm",
        worst <= 2e-3,
    )
