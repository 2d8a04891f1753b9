"""The outline of the object inside a push, found among the nodes of its mesh."""

import cv2
import numpy as np
import pytest

from deformpush.mechanics.geometry import rotation
from deformpush.mechanics.mesh import slab
from deformpush.record import palette
from deformpush.viewer.inside_push import outline
from tests.record.synthetic import CAMERA, TOOL
from tests.record.synthetic import outline as rectangle
from tests.viewer.test_bottom_view import px

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


def test_outline_and_tool_are_drawn_at_every_moment_of_a_push(full):
    """On `sim_time` alone: on `push` there is nothing between two states."""
    strips = full.contents.at("/camera/inside/outline", "LineStrips2D:strips", "sim_time")
    tools = full.contents.at("/camera/inside/tool", "Points2D:positions", "sim_time")
    rim = outline(full.rows[0].view.nodes, full.info.scenery.mesh_triangles)
    moments = {
        round(1e9 * (before.timing.sim_time_s + moment.time_s)): moment
        for before, row in zip(full.rows, full.rows[1:], strict=False)
        for moment in row.action.outcome.motion
    }
    assert list(strips) == list(tools) == list(moments)
    for at, moment in moments.items():
        np.testing.assert_allclose(strips[at][0], px(moment.nodes[rim, :2]), atol=1e-3)
        np.testing.assert_allclose(tools[at][0], px(moment.tool[None, :2])[0], atol=1e-3)
    for entity in ("/camera/inside/outline", "/camera/inside/tool"):
        assert full.contents.times(entity, "push") == []
    assert list(full.contents.at("/camera/inside", "Clear:is_recursive")) == list(range(13))


def test_the_tool_is_as_wide_as_it_is(full):
    (radius,) = full.contents.fixed("/camera/inside/tool", "Points2D:radii")
    assert radius == pytest.approx(TOOL * CAMERA.scale)
    assert full.contents.colours("/camera/inside/tool", "Points2D:colors") == [palette.TOOL]
    assert full.contents.colours("/camera/inside/outline", "LineStrips2D:colors") == [palette.CONTOUR]


def test_without_a_mesh_the_tool_is_drawn_alone(plain):
    assert plain.contents.times("/camera/inside/outline", "sim_time") == []
    assert len(plain.contents.times("/camera/inside/tool", "sim_time")) == 10
