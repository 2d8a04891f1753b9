"""The scene: where things are, and the colour of the soft object, its strain against its limit."""

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.viewer.scene import FULL_STRAIN, strain_colours
from tests.record.synthetic import LIMIT, THICKNESS, TOOL
from tests.viewer.recording import rgb


def test_without_strain_the_object_has_its_own_colour():
    assert strain_colours(np.zeros(2), 0.1).tolist() == [list(palette.OBJECT)] * 2


def test_beyond_the_limit_the_colour_is_another_one():
    at = strain_colours(np.array([0.05, 0.1, 0.1000001, 0.5]), 0.1)
    assert at[1].tolist() == list(palette.STRAIN[-1]), "the limit itself is allowed"
    assert at[2].tolist() == at[3].tolist() == list(palette.HARM)
    lightness = at.astype(float).mean(axis=-1)
    assert lightness[0] < lightness[1], "paler up to the limit"
    assert lightness[1] - lightness[2] > 100, "also told apart in grey"


def test_without_a_limit_nothing_is_said_to_be_harmed():
    at = strain_colours(np.array([[0.0, FULL_STRAIN], [0.5, FULL_STRAIN / 2]]), None)
    assert at.shape == (2, 2, 3)
    assert at[0, 1].tolist() == at[1, 0].tolist() == list(palette.STRAIN[-1])
    assert at[1, 1].tolist() == list(palette.STRAIN[1])


def test_the_scene_holds_table_goal_and_triangles(full):
    scenery = full.info.scenery
    np.testing.assert_allclose(full.contents.fixed("/scene/table", "Boxes3D:centers"), [scenery.table_centre])
    halves = full.contents.fixed("/scene/table", "Boxes3D:half_sizes")
    np.testing.assert_allclose(halves, [scenery.table_half_size])
    goal = np.array(full.contents.fixed("/scene/goal", "LineStrips3D:strips")[0])
    outline = full.info.target.outline
    np.testing.assert_allclose(goal[:, :2], np.vstack([outline, outline[:1]]), atol=1e-6)
    assert (goal[:, 2] > 0).all(), "above the table"
    assert full.contents.colours("/scene/goal", "LineStrips3D:colors") == [palette.GOAL]
    triangles = full.contents.fixed("/scene/object", "Mesh3D:triangle_indices")
    np.testing.assert_array_equal(triangles, scenery.mesh_triangles)


def test_between_pushes_the_object_shows_the_peak_strain_of_the_push_before(full):
    nodes = full.contents.at("/scene/object", "Mesh3D:vertex_positions")
    colours = full.contents.at("/scene/object", "Mesh3D:vertex_colors")
    assert list(nodes) == list(colours) == list(range(13))
    for row in full.rows:
        np.testing.assert_allclose(nodes[row.k], row.view.nodes, atol=1e-6)
        strain = np.zeros(len(row.view.nodes)) if row.k == 0 else row.action.outcome.strain.at_nodes
        assert [rgb(one) for one in colours[row.k]] == [tuple(c) for c in strain_colours(strain, LIMIT)]


def test_inside_a_push_the_object_shows_the_strain_of_the_moment(full):
    nodes = full.contents.at("/scene/object", "Mesh3D:vertex_positions", "sim_time")
    colours = full.contents.at("/scene/object", "Mesh3D:vertex_colors", "sim_time")
    for before, row in zip(full.rows, full.rows[1:], strict=False):
        for moment in row.action.outcome.motion[:-1]:  # the last one falls on the state that follows
            at = round(1e9 * (before.timing.sim_time_s + moment.time_s))
            np.testing.assert_allclose(nodes[at], moment.nodes, atol=1e-6)
            expected = [tuple(c) for c in strain_colours(moment.strain, LIMIT)]
            assert [rgb(one) for one in colours[at]] == expected


def test_the_next_push_is_an_arrow_above_the_object(full):
    origins = full.contents.at("/scene/next_push", "Arrows3D:origins")
    vectors = full.contents.at("/scene/next_push", "Arrows3D:vectors")
    assert list(origins) == list(range(12))
    for row in full.rows[1:]:
        path = row.action.path
        np.testing.assert_allclose(origins[row.k - 1][0], [*path.start, THICKNESS], atol=1e-6)
        np.testing.assert_allclose(vectors[row.k - 1][0], [*(path.end - path.start), 0], atol=1e-6)
    assert list(full.contents.at("/scene/next_push", "Clear:is_recursive")) == list(range(13))


def test_the_arm_stands_on_its_base_and_each_joint_is_placed_at_each_instant(full):
    assert full.contents.fixed("/scene/base", "Transform3D:child_frame") == ["lbr_iiwa_link_0"]
    assert len(full.contents.times("/scene/joints", "push")) == 7 * 13
    assert len(full.contents.times("/scene/joints", "sim_time")) == 7 * (13 + 60)
    assert "/scene/tool" not in full.contents.entities
    links = {name for name in full.contents.entities if name.startswith("/scene/lbr_iiwa/")}
    assert sum("visual_geometries" in name for name in links) >= 8
    assert not any("collision_geometries" in name for name in links)


def test_a_bare_tool_is_drawn_without_an_arm(plain):
    places = plain.contents.at("/scene/tool", "Transform3D:translation", "sim_time")
    for before, row in zip(plain.rows, plain.rows[1:], strict=False):
        for moment in row.action.outcome.motion:
            at = round(1e9 * (before.timing.sim_time_s + moment.time_s))
            np.testing.assert_allclose(places[at][0], moment.tool + np.array([0, 0, 0.05]), atol=1e-6)
    assert plain.contents.fixed("/scene/tool", "Cylinders3D:radii") == [pytest.approx(TOOL)]
    assert "/scene/joints" not in plain.contents.entities
    assert "/scene/object" not in plain.contents.entities, "there is no mesh"
