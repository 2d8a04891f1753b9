"""What the optimizer may see of the object under the tool."""

import numpy as np
import pytest

from deformpush.cell.cell import know, look, nearest_reachable
from deformpush.config.compose import compose
from deformpush.experiment.assemble import build_cell
from deformpush.loop import start
from deformpush.mechanics.geometry import resample, signed_area
from deformpush.mechanics.outline_change import contour_change


@pytest.mark.parametrize("kappa", [0.2, 0.5])
def test_a_rigid_object_shows_no_dent_under_the_tool(kappa):
    """Of what is held against a strain limit, a camera must not make anything up."""
    cell = build_cell(compose(["world=toy", "robot=tool", "object=fish_fillet", "record=off"]))
    begin = start(cell)
    seen, target = begin.seen, begin.target
    errors = cell.task.errors(seen, target)
    before = know(cell, seen, target, errors, 1.0)
    assert before.pressed() == []
    _, path = nearest_reachable(cell, np.array([kappa, 0.03]), seen)
    outcome = cell.world.push(path)
    after = know(cell, look(cell, seen)[0], target, errors, 1.0, outcome)
    (rest,), looks = before.at_rest(), after.pressed()
    assert len(looks) == len(outcome.film) > 3
    assert np.linalg.norm(looks[-1].mean(axis=0) - rest.mean(axis=0)) > 0.01, "it was moved"
    pixel = 1 / cell.camera.scale / np.sqrt(signed_area(resample(rest, 128)))
    assert max(contour_change(rest, one).dent for one in looks) < 0.5 * pixel
