"""The colour of the soft object: its strain against its limit."""

import numpy as np

from deformpush.record import palette
from deformpush.viewer.scene import FULL_STRAIN, strain_colours


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
