"""The engine's law: closed forms, energy as the integral of stress, and the engine itself."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.checks.by_world import build_bench
from deformpush.mechanics.material import Material
from deformpush.mechanics.mesh import slab
from deformpush.mechanics.neo_hookean import NeoHookean, cofactor, von_mises
from deformpush.mechanics.strain import RestShape
from deformpush.worlds.bullet.engine import SoftBody, connect
from tests.mechanics.test_strain import XY, gradient, rotation, seeds

MATERIAL = Material(2e4, 0.35, 0.5, mass=0.2)
LAW = NeoHookean.of(MATERIAL)
MU, LAM = MATERIAL.lame
materials = st.builds(
    Material,
    youngs_modulus=st.floats(1e3, 1e6),
    poisson_ratio=st.floats(0.0, 0.49),
    friction=st.just(0.5),
    mass=st.just(0.2),
)


@given(materials, seeds)
def test_at_small_strain_it_is_hookes_law(material, seed):
    mu, lam = material.lame
    law = NeoHookean.of(material)
    e = np.random.default_rng(seed).uniform(-1, 1, (3, 3))
    e, h = (e + e.T) / 2, 1e-6
    slope = (law.piola(np.eye(3) + h * e) - law.piola(np.eye(3) - h * e)) / (2 * h)
    np.testing.assert_allclose(
        slope, 2 * mu * e + lam * np.trace(e) * np.eye(3), rtol=0, atol=1e-6 * (mu + lam)
    )


@given(seeds)
def test_a_rigid_body_has_neither_stress_nor_energy(seed):
    R = rotation(np.random.default_rng(seed))
    assert np.abs(LAW.piola(R)).max() < 1e-10
    assert von_mises(LAW.cauchy(R)) < 1e-10
    assert abs(LAW.energy(R)) < 1e-10


@pytest.mark.parametrize("factor", [0.8, 1.1, 1.4])
def test_a_uniform_stretch_is_pressure_alone(factor):
    """With stretch a: sigma = [mu a (1 - 1/(3 a^2 + 1)) + (lambda (a^3 - 1) - 3/4 mu) a^2] / a^2."""
    a, (mu, lam) = factor, MATERIAL.bullet
    stress = LAW.cauchy(a * np.eye(3))
    pressure = (mu * a * (1 - 1 / (3 * a**2 + 1)) + (lam * (a**3 - 1) - 0.75 * mu) * a**2) / a**2
    np.testing.assert_allclose(stress, pressure * np.eye(3), rtol=0, atol=1e-9)
    assert von_mises(stress) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("shear", [0.01, 0.2, 0.8])
def test_simple_shear_of_the_textbook(shear):
    """J = 1, B = FF': sigma = mu (1 - 1/(g^2 + 4)) B - 3/4 mu I."""
    F = np.eye(3) + shear * XY
    mu, _ = MATERIAL.bullet
    c = mu * (1 - 1 / (shear**2 + 4))
    expected = c * np.array([[1 + shear**2, shear, 0], [shear, 1, 0], [0, 0, 1]]) - 0.75 * mu * np.eye(3)
    np.testing.assert_allclose(LAW.cauchy(F), expected, rtol=1e-9, atol=1e-9)
    along = c * np.sqrt(shear**4 + 3 * shear**2)
    assert von_mises(LAW.cauchy(F)) == pytest.approx(along, rel=1e-9)
    psi = mu / 2 * (shear**2 - np.log((shear**2 + 4) / 4))
    assert LAW.energy(F) == pytest.approx(psi, rel=1e-9)


@given(materials, seeds)
def test_energy_is_the_work_of_the_stress_along_the_way(material, seed):
    """Psi(F) = integral of P : dF from rest, by Gauss and Legendre along the straight way."""
    law, F = NeoHookean.of(material), gradient(np.random.default_rng(seed), 0.2)
    F = F if np.linalg.norm(F - np.eye(3)) < 1.5 else np.eye(3) + 0.3 * (F - np.eye(3))
    at, weight = np.polynomial.legendre.leggauss(24)
    way = np.eye(3) + (at[:, None, None] + 1) / 2 * (F - np.eye(3))
    work = np.sum(weight / 2 * np.sum(law.piola(way) * (F - np.eye(3)), axis=(1, 2)))
    assert law.energy(F) == pytest.approx(work, rel=1e-9, abs=1e-9 * law.mu)


@given(seeds)
def test_stress_turns_with_the_body_and_energy_does_not(seed):
    rng = np.random.default_rng(seed)
    F, turn = gradient(rng), rotation(rng)
    np.testing.assert_allclose(LAW.cauchy(turn @ F), turn @ LAW.cauchy(F) @ turn.T, rtol=0, atol=1e-8)
    np.testing.assert_allclose(LAW.cauchy(F @ turn), LAW.cauchy(F), rtol=0, atol=1e-8)
    for other in (turn @ F, F @ turn):
        assert LAW.energy(other) == pytest.approx(LAW.energy(F), rel=1e-9)
        assert von_mises(LAW.cauchy(other)) == pytest.approx(von_mises(LAW.cauchy(F)), rel=1e-9)
    np.testing.assert_allclose(LAW.cauchy(F), LAW.cauchy(F).T, rtol=0, atol=1e-8)


@given(seeds)
def test_cofactor(seed):
    F = np.random.default_rng(seed).normal(size=(3, 3))
    np.testing.assert_allclose(cofactor(F).T @ F, np.linalg.det(F) * np.eye(3), rtol=0, atol=1e-12)


def test_its_forces_balance_gravity_in_the_engine_far_beyond_small_strain():
    """A slab hung by one end until it is a fifth longer: at every free node, elastic force plus weight is 0.

    The force of a tetrahedron on its corners is -V P Dm^-T (Sifakis and Barbic 2012), on the first minus
    their sum. Were the engine's law another one, the balance would hold at small strain only.
    """
    pytest.importorskip("pybullet")
    bench = build_bench(["object.dt=0.002"])
    sheet = replace(bench.sheet, material=Material(1e4, 0.3, 0.5, mass=0.2), start=(0.0, 0.0))
    client = connect(bench.spec.engine)
    mesh = slab(sheet.polygon, sheet.thickness, sheet.cell)
    body = SoftBody(client, bench.spec.engine, bench.spec.margin, mesh, sheet)
    held = np.isclose(mesh.nodes[:, 0], mesh.nodes[:, 0].min())
    pull = 40.0
    client.setGravity(pull, 0, 0)
    for node in np.flatnonzero(held):
        client.createSoftBodyAnchor(body.id, int(node), -1, -1)
    for _ in range(4000):
        client.stepSimulation()
    nodes = body.nodes()
    client.disconnect()

    rest = RestShape(mesh)
    F = rest.gradients(nodes)
    assert rest.strain(nodes).max() > 0.15
    P = NeoHookean.of(sheet.material).piola(F)
    corners = np.stack([mesh.nodes[mesh.tetrahedra[:, i]] for i in range(4)])
    inverse = np.linalg.inv(np.stack([corners[i] - corners[0] for i in (1, 2, 3)], axis=-1))
    on_others = -mesh.volumes[:, None, None] * P @ np.swapaxes(inverse, -1, -2)
    force = np.zeros_like(nodes)
    for i in range(3):
        np.add.at(force, mesh.tetrahedra[:, i + 1], on_others[..., i])
    np.add.at(force, mesh.tetrahedra[:, 0], -on_others.sum(axis=-1))
    weight = 0.2 / len(nodes) * pull
    force[:, 0] += weight
    assert np.abs(force[~held]).max() < 0.01 * weight
    assert np.abs(force[held]).max() > weight, "what hangs there is held"
