"""The draws are torch's scrambled Sobol points to the last bit, with mean 0 and spread 1."""

import numpy as np
import pytest
from scipy.stats.qmc import Sobol, discrepancy

from deformpush.model.normal_draws import BITS, directions, normal_draws, scrambled_sobol


@pytest.mark.parametrize("samples", [1, 2, 60, 256])
def test_the_points_are_those_of_torch_to_the_bit(samples):
    torch = pytest.importorskip("torch")
    points = torch.quasirandom.SobolEngine(4, scramble=True, seed=0).draw(samples, dtype=torch.float64)
    np.testing.assert_array_equal(scrambled_sobol(samples), points.numpy())


def test_the_direction_numbers_are_those_of_joe_and_kuo():
    """Without scrambling, point 2^j is direction number j mixed with those before it, as scipy has it too."""
    gray = [n ^ n >> 1 for n in range(256)]
    plain = [
        np.bitwise_xor.reduce(directions()[:, [j for j in range(BITS) if g >> j & 1]], axis=1) for g in gray
    ]
    np.testing.assert_array_equal(np.array(plain) / 2.0**BITS, Sobol(4, scramble=False).random(256))


def test_they_are_spread_more_evenly_than_random_points():
    random = np.random.default_rng(0).random((64, 4))
    assert discrepancy(scrambled_sobol(64)) < 0.3 * discrepancy(random)


@pytest.mark.parametrize("samples", [4, 64])
def test_mean_and_spread_are_exact_and_the_draws_are_kept(samples):
    z = normal_draws(samples)
    np.testing.assert_allclose((z.mean(axis=0), z.std(axis=0)), ([0] * 4, [1] * 4), atol=1e-14)
    assert normal_draws(samples) is z
    with pytest.raises(ValueError, match="read-only"):
        z += 1.0
