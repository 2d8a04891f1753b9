"""Objects that are not star-shaped, in the engine: they lie still, keep their area, and yield to a push."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.cell.push import ToolPath
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import signed_area
from tests.outlines import OUTLINES

SETTINGS = compose(["robot=tool"])
SPEC, ROBOT, CAMERA = (config.build(SETTINGS[group]) for group in ("world", "robot", "camera"))
RECT = config.build(SETTINGS.object)
LEAD, WAY = 0.006, 0.03
TOOL = 0.01


def plan(world):
    """Corners `(V, 2)` of the underside as it lies now: the rim's nodes are the first of the mesh."""
    mesh = world.mesh
    under = mesh.surface()
    under = under[np.all(mesh.nodes[under][:, :, 2] < 1e-9, axis=1)]
    sides = {(b, a) for f in under.tolist() for a, b in zip(f, f[1:] + f[:1], strict=True)}
    return world.nodes()[sorted(a for a, b in sides if (b, a) not in sides), :2]


@pytest.mark.parametrize("turn_deg", [0.0, 60.0])
@pytest.mark.parametrize("name", ["ell", "tee", "kidney"])
def test_a_soft_object_of_any_outline_can_be_pushed(name, turn_deg):
    """The material of rect, E = 10 kPa; a push of 30 mm against the point that lies lowest."""
    sheet = replace(RECT, outline=tuple(map(tuple, OUTLINES[name].tolist())), start_deg=turn_deg)
    assert sheet.slab.layout == "free"
    assert sheet.material.youngs_modulus == 1e4
    world = SPEC.build(sheet, ROBOT, CAMERA, TOOL)
    before = plan(world)
    area = signed_area(sheet.polygon)
    assert signed_area(before) == pytest.approx(area, rel=0.01)
    lowest = before[np.isclose(before[:, 1], before[:, 1].min(), atol=1e-3)].mean(axis=0)
    start = lowest - (0, TOOL + SPEC.margin + LEAD)
    outcome = world.push(ToolPath(start, np.array([0.0, 1.0]), LEAD, WAY))
    after = plan(world)
    world.close()
    assert signed_area(after) == pytest.approx(area, rel=0.02)
    assert 0.005 < (after.mean(axis=0) - before.mean(axis=0))[1] < WAY
    assert 0 < outcome.strain.residual < outcome.strain.p99_peak < 1
    gap = np.linalg.norm(after - np.add(start, (0, LEAD + WAY)), axis=1).min() - TOOL
    assert gap > -3e-3, "it lies beside where the tool was, but for the dent that springs back"
