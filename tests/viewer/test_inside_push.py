"""The outline of the object inside a push, found among the nodes of its mesh."""

import cv2
import numpy as np
import pytest

from deformpush.mechanics.mesh import slab
from deformpush.viewer.inside_push import outline
from tests.record.synthetic import outline as rectangle
from tests.record.synthetic import rotation

ROUND = np.stack([f(np.linspace(0, 2 * np.pi, 60, endpoint=False)) for f in (np.cos, np.sin)], 1) * (
    0.1,
    0.06,
)


@pytest.mark.parametrize("shape", [rectangle(), ROUND], ids=["rectangle", "ellipse"])
def test_the_rim_goes_once_around_the_underside(shape):
    mesh = slab(shape, 0.02, 0.02)
    rim = outline(mesh.nodes, mesh.surface())
    assert rim[0] == rim[-1]
    assert len(set(rim)) == len(rim) - 1
    assert (mesh.nodes[rim, 2] == mesh.nodes[:, 2].min()).all()
    area = cv2.contourArea(mesh.nodes[rim, :2].astype(np.float32))
    assert area == pytest.approx(cv2.contourArea(shape.astype(np.float32)), rel=0.03)


def test_it_holds_every_node_of_a_bent_slab():
    """The nodes are found in the flat slab once and keep their order in whatever it becomes."""
    mesh = slab(rectangle(), 0.02, 0.02)
    rim = outline(mesh.nodes, mesh.surface())
    bent = mesh.nodes[:, :2] @ rotation(0.8).T + (0.5, -0.1) + 0.5 * mesh.nodes[:, :1] ** 2
    lowest = np.flatnonzero(mesh.nodes[:, 2] == mesh.nodes[:, 2].min())
    inside = [cv2.pointPolygonTest(bent[rim].astype(np.float32), p.tolist(), True) for p in bent[lowest]]
    assert min(inside) > -1e-6


def test_without_a_level_face_there_is_none():
    wall = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert outline(wall, np.array([[0, 1, 2]])) is None
