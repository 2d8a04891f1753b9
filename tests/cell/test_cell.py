"""What is made out of the object while the tool pushes."""

import numpy as np
import pytest

from deformpush.experiment.assemble import build_cell
from deformpush.mechanics.geometry import resample, signed_area
from deformpush.mechanics.outline_change import contour_change
from deformpush.worlds.toy import ToyWorld
from tests.setups import setup


@pytest.mark.parametrize("kappa", [0.2, 0.5])
def test_a_rigid_object_shows_no_dent_under_the_tool(kappa):
    """A camera must make up nothing of what is held against a strain limit."""
    cell = build_cell(setup("world=toy", "robot=tool", "object=fish_fillet", "record=off"))
    before, _ = cell.look(None)
    (rest,), seen = cell.outlines([before.nodes]), before.seen
    _, path = cell.reachable(np.array([kappa, 0.03]), seen)
    outcome = cell.world.push(path)
    looks = cell.outlines(outcome.film)
    assert len(looks) == len(outcome.film) > 3
    assert np.linalg.norm(looks[-1].mean(axis=0) - rest.mean(axis=0)) > 0.01, "it was moved"
    pixel = 1 / cell.camera.scale / np.sqrt(signed_area(resample(rest, 128)))
    assert max(contour_change(rest, one).dent for one in looks) < 0.5 * pixel


def test_without_a_mesh_no_outline_is_made_up(monkeypatch):
    cell = build_cell(setup("world=toy", "robot=tool"))
    nodes = cell.world.nodes()
    assert len(cell.outlines([nodes, None, nodes])) == 2
    bare = type(cell.world.scenery())()
    monkeypatch.setattr(ToyWorld, "scenery", lambda self: bare)
    assert cell.outlines([nodes]) == ()
