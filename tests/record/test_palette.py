"""Colours that meet in one picture can be told apart, whatever one's colour vision."""

from itertools import combinations

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.task import TERMS

# Machado, Oliveira, Fernandes (2009), severity 1.0, on linear RGB.
VISION = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}
PICTURES = {
    "errors": [term.colour for term in TERMS],
    "actions": [palette.KAPPA, palette.D, palette.XI],
    "bottom view": [palette.OBJECT, palette.GOAL, palette.NEXT_PUSH, (255, 255, 255)],
    "runs": list(palette.RUNS),
    "phases": list(palette.PHASES.values()),
}


def linear(colour) -> np.ndarray:
    c = np.asarray(colour) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIE L*a*b* (D65) of linear RGB."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    x, y, z = np.cbrt(np.clip(to_xyz @ rgb / to_xyz.sum(1), 1e-4, None))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("picture", PICTURES)
def test_colours_of_one_picture_are_apart(picture, vision):
    seen = [lab(np.clip(VISION[vision] @ linear(colour), 0, 1)) for colour in PICTURES[picture]]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 20


@pytest.mark.parametrize("colours", [palette.RAMP, palette.ALONG, palette.STRAIN])
def test_ramps_change_lightness_in_one_direction(colours):
    shades = palette.ramp(np.linspace(0, 1, 20), colours)
    steps = np.diff([lab(linear(shade))[0] for shade in shades])
    assert (steps > 0).all() or (steps < 0).all()


def test_ramp_takes_the_ends_beyond_its_range():
    np.testing.assert_array_equal(
        palette.ramp(np.array([-1.0, 0.0, 1.0, 7.0])),
        [palette.RAMP[0], palette.RAMP[0], palette.RAMP[-1], palette.RAMP[-1]],
    )
