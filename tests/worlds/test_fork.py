"""A branch sees everything and changes nothing."""

import os

import numpy as np
import pytest

from deformpush import loop as runner
from deformpush.cell.cell import know, look
from deformpush.config.compose import compose
from deformpush.experiment.assemble import build_cell
from deformpush.worlds.fork import branched


def test_results_come_in_order_and_failures_as_none():
    jobs = [lambda i=i: 10 // i for i in (1, 2, 0, 5)]
    assert branched(jobs, 3) == [10, 5, None, 2]


def test_a_copy_that_dies_is_a_failure_too():
    assert branched([lambda: os.abort(), lambda: 1], 2) == [None, 1]


def test_large_results_pass():
    (back,) = branched([lambda: np.arange(10**6)], 1)
    assert back.sum() == sum(range(10**6))


@pytest.mark.parametrize("scene", ["world=toy", pytest.param("world=bullet", marks=pytest.mark.slow)])
def test_trials_foretell_a_push_and_leave_the_world_alone(scene):
    cell = build_cell(compose([scene, "robot=tool", "optimizer=random"]))
    begin = runner.start(cell)
    errors = cell.task.errors(begin.seen, begin.target)
    state = know(cell, begin.seen, begin.target, errors, errors.e_T)
    U = np.array([[0.5, 0.03], [0.25, 0.02]])
    before = cell.world.nodes()
    foretold = state.trials(U)
    np.testing.assert_array_equal(cell.world.nodes(), before)
    cell.world.push(cell.push.plan(U[1], begin.seen, cell.part))
    seen, *_ = look(cell, begin.seen)
    assert cell.task.errors(seen, begin.target).e_T == foretold[1] != foretold[0]
    cell.world.close()
