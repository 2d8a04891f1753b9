"""A branch sees everything and changes nothing."""

import os

import numpy as np
import pytest

from deformpush.worlds.fork import branched
from tests.setups import begun, setup


def test_results_come_in_order_and_failures_as_none():
    jobs = [lambda i=i: 10 // i for i in (1, 2, 0, 5)]
    assert branched(jobs, 3) == [10, 5, None, 2]


def test_a_copy_that_dies_is_a_failure_too():
    assert branched([lambda: os.abort(), lambda: 1], 2) == [None, 1]


def test_large_results_pass():
    (back,) = branched([lambda: np.arange(10**6)], 1)
    assert back.sum() == sum(range(10**6))


@pytest.mark.parametrize("scene", ["world=toy", pytest.param("world=bullet", marks=pytest.mark.slow)])
def test_branches_foretell_a_push_and_leave_the_world_alone(scene):
    episode = begun(setup(scene, "robot=tool", "optimizer=random"))
    world = episode.cell.world
    U = np.array([[0.5, 0.03], [0.25, 0.02]])
    before = world.nodes()
    foretold = episode.e_T_after(U)
    np.testing.assert_array_equal(world.nodes(), before)
    after = episode.push(u=U[1])
    assert after.errors.e_T == foretold[1] != foretold[0]
    world.close()


def test_a_branch_that_fails_is_not_a_number():
    episode = begun(setup("world=toy", "robot=tool", "optimizer=random"))
    out_of_the_picture, fair = [0.5, 3.0], [0.5, 0.02]
    e_T = episode.e_T_after(np.array([out_of_the_picture, fair]))
    assert np.isnan(e_T).tolist() == [True, False]
