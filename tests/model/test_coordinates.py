"""Model coordinates there and back, and the one grid of pushes."""

import numpy as np

from deformpush.model.coordinates import from_model, grid, grid_over, share_of_longest, to_model

OUTER = np.array([[0.1, 0.9], [0.01, 0.03]])


def test_d_is_scaled_to_the_outer_bounds_and_kappa_stays():
    U = np.array([[0.1, 0.01], [0.4, 0.02], [0.9, 0.03]])
    scaled = to_model(U, OUTER)
    np.testing.assert_allclose(scaled, [[0.1, 0.0], [0.4, 0.5], [0.9, 1.0]])
    np.testing.assert_allclose(from_model(scaled, OUTER), U)
    np.testing.assert_allclose(from_model(scaled[1], OUTER), U[1])
    np.testing.assert_allclose(share_of_longest(scaled, OUTER[1]), U[:, 1] / 0.03)


def test_a_grid_holds_every_pair_and_kappa_runs_faster():
    assert grid(np.array([1.0, 2.0]), np.array([5.0, 6.0])).tolist() == [[1, 5], [2, 5], [1, 6], [2, 6]]
    over = grid_over(OUTER, 5, 3)
    assert over.shape == (15, 2)
    np.testing.assert_array_equal([over.min(axis=0), over.max(axis=0)], OUTER.T)
    np.testing.assert_allclose(np.unique(over[:, 1]), [0.01, 0.02, 0.03])
