"""Local stretch, the colour of the soft object."""

import numpy as np
import pytest

from deformpush.record.scene import Stretch
from deformpush.sim.mesh import slab
from tests.record.synthetic import outline, rotation


@pytest.fixture
def mesh():
    return slab(outline(), 0.02, 0.02)


def test_a_rigid_motion_is_no_stretch(mesh):
    moved = mesh.nodes.copy()
    moved[:, :2] = moved[:, :2] @ rotation(0.7).T + (0.5, -0.2)
    np.testing.assert_allclose(Stretch(mesh.nodes, mesh.surface())(moved), 0, atol=1e-12)


def test_growing_by_a_share_is_that_stretch_everywhere(mesh):
    stretch = Stretch(mesh.nodes, mesh.surface())(np.stack([mesh.nodes * 1.05, mesh.nodes * 0.9]))
    np.testing.assert_allclose(stretch, np.repeat([[0.05], [0.1]], len(mesh.nodes), axis=1))


def test_only_the_nodes_around_a_moved_one_change(mesh):
    moved = mesh.nodes.copy()
    moved[0] += (0.0, 0.0, 0.004)
    changed = np.flatnonzero(Stretch(mesh.nodes, mesh.surface())(moved))
    neighbours = np.unique(mesh.surface()[(mesh.surface() == 0).any(1)])
    assert set(changed) == set(neighbours)
