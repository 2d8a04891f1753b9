"""The pushes that `regret` tries from every state; what it finds: tests/cli/test_regret.py."""

import numpy as np

from deformpush.experiment.true_regret import candidates
from deformpush.record.regret_table import PUSHES


def test_the_pushes_are_spread_over_the_bounds_and_always_the_same():
    outer = np.array([[0.0, 1.0], [0.01, 0.03]])
    U = candidates(PUSHES, outer)
    np.testing.assert_array_equal(U, candidates(PUSHES, outer))
    assert U.shape == (PUSHES, 2)
    unit = (U - outer[:, 0]) / (outer[:, 1] - outer[:, 0])
    assert (np.sort((unit[:, 0] * PUSHES).astype(int)) == np.arange(PUSHES)).all()
    assert (U[::2, 1] == 0.03).all()
    assert U[1::2, 1].min() == 0.01
    assert len(set(U[1::2, 1])) == PUSHES // 2
    cells = {(int(4 * min(kappa, 0.999)), int(3 * min(d, 0.999))) for kappa, d in unit}
    assert len(cells) == 12
    np.testing.assert_array_equal(candidates(1, outer), [[0.5, 0.03]])
