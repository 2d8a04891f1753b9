"""Rounding where numbers change hands."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.mechanics import rounding
from deformpush.mechanics.rounding import METRES, TIE, lowest, lowest_first, rounded

numbers = st.floats(-10.0, 10.0)


@given(st.floats(-np.pi, np.pi))
def test_directions_are_unit_vectors_and_shrug_off_the_last_bits(angle):
    v = np.array([np.cos(angle), np.sin(angle)])
    unit = rounding.direction(v)
    assert abs(rounding.length(unit) - 1.0) <= 2.3e-16
    np.testing.assert_allclose(unit, v, atol=2e-9)


def test_noise_is_rounded_away():
    rng = np.random.default_rng(0)
    x = rng.uniform(-0.5, 0.5, 1000)
    noisy = x * (1.0 + 1e-15 * rng.normal(size=1000))
    assert np.any(x != noisy)
    np.testing.assert_array_equal(rounded(x, METRES), rounded(noisy, METRES))
    U = np.stack([x, noisy], axis=1)
    np.testing.assert_array_equal(rounding.push(U), rounding.push(U + 1e-16))
    for a, b in zip(x, noisy, strict=True):
        assert rounding.reported(a) == rounding.reported(b) == pytest.approx(a, rel=1e-6)


def test_what_is_rounded_once_stays():
    x = rounded(np.random.default_rng(1).uniform(-1, 1, 1000), METRES)
    np.testing.assert_array_equal(rounded(x, METRES), x)


@given(st.lists(numbers, min_size=1, max_size=20))
def test_the_lowest_is_no_more_than_a_tie_above_the_minimum_and_the_first_there(values):
    x = np.array(values)
    first = lowest(x)
    tie = TIE * np.abs(x).max()
    assert x[first] <= x.min() + tie
    assert np.all(x[:first] > x.min() + tie)


def test_of_values_alike_the_first_counts_whatever_the_last_bit_says():
    assert lowest(np.array([3.0, 1.0 + 1e-15, 1.0, 2.0])) == 1
    assert lowest(np.array([3.0, 1.0, 1.0 + 1e-15, 2.0])) == 1
    assert lowest(np.array([np.inf, np.nan, 0.5, 0.5 - 1e-16])) == 2
    assert lowest(np.array([0.0, 0.0])) == 0
    assert lowest(np.full(3, np.inf)) == 0
    assert lowest_first(np.array([2.0, 1.0 + 1e-15, 1.0, -3.0])).tolist() == [3, 1, 2, 0]
    assert lowest_first(np.array([np.inf, 1.0, -np.inf])).tolist() == [2, 1, 0]
    assert lowest_first(np.zeros(3)).tolist() == [0, 1, 2]
