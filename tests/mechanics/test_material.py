"""Material in a user's terms and in PyBullet's."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.mechanics.material import Material

materials = st.builds(
    Material,
    youngs_modulus=st.floats(1e3, 1e6),
    poisson_ratio=st.floats(0.0, 0.49),
    friction=st.just(0.5),
    mass=st.just(0.2),
)


@given(materials)
def test_lame_parameters_give_back_modulus_and_ratio(material):
    mu, lam = material.lame
    assert mu * (3 * lam + 2 * mu) / (lam + mu) == pytest.approx(material.youngs_modulus)
    assert lam / (2 * (lam + mu)) == pytest.approx(material.poisson_ratio, abs=1e-12)


@given(materials)
def test_bullets_numbers_invert_its_linearisation(material):
    (mu, lam), (mu_b, lam_b) = material.lame, material.bullet
    assert 3 / 4 * mu_b == pytest.approx(mu)
    assert lam_b - 5 / 8 * mu_b == pytest.approx(lam, abs=1e-9 * mu)


def test_mass_or_density():
    by_mass = Material(1e4, 0.3, 0.5, mass=0.2)
    by_density = Material(1e4, 0.3, 0.5, density=1050.0)
    assert by_mass.total_mass(4e-4) == 0.2
    assert by_density.total_mass(4e-4) == pytest.approx(0.42)
    for both_or_none in ({}, {"mass": 0.2, "density": 1000.0}):
        with pytest.raises(ValueError, match=r"^mass: give either mass \(kg\) or density"):
            Material(1e4, 0.3, 0.5, **both_or_none)


def test_scaled():
    material = Material(1e4, 0.3, 0.5, mass=0.2)
    assert material.scaled(2, 3, 4) == replace(material, youngs_modulus=2e4, friction=1.5, mass=0.8)
    assert Material(1e4, 0.3, 0.5, density=1e3).scaled(1, 1, 4).density == 4e3
