"""Where the tool can push, and what is made out of the object while it does."""

import numpy as np
import pytest

from deformpush.cell.world import WorldError
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


def test_a_push_out_of_reach_becomes_the_nearest_one_within(monkeypatch):
    cell = build_cell(setup("world=toy", "robot=tool"))
    seen = cell.look(None)[0].seen
    wanted = np.array([0.02, 0.02])  # on the far side, from above
    u, path = cell.reachable(wanted, seen)
    np.testing.assert_array_equal(u, wanted)
    low = seen.c[1]
    monkeypatch.setattr(ToyWorld, "can_reach", lambda self, points: points[:, 1] < low)
    u, path = cell.reachable(wanted, seen)
    assert u[1] == 0.02
    assert max(path.start[1], path.end[1]) < low
    moved = abs(u[0] - wanted[0])
    for nearer in np.arange(0, min(moved, 1 - moved) - 0.005, 0.01):
        for kappa in ((wanted[0] + nearer) % 1, (wanted[0] - nearer) % 1):
            blocked = cell.layout.plan(np.array([kappa, 0.02]), seen, cell.part)
            assert max(blocked.start[1], blocked.end[1]) >= low
    np.testing.assert_array_equal(path.start, cell.layout.plan(u, seen, cell.part).start)


def test_an_object_no_push_can_reach_ends_the_run(monkeypatch):
    cell = build_cell(setup("world=toy", "robot=tool"))
    seen = cell.look(None)[0].seen
    monkeypatch.setattr(ToyWorld, "can_reach", lambda self, points: np.zeros(len(points), bool))
    with pytest.raises(WorldError, match="can reach no push of 20 mm"):
        cell.reachable(np.array([0.5, 0.02]), seen)
