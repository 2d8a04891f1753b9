"""Strain of meshes against closed forms, and what must hold for any deformation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.mechanics.mesh import slab
from deformpush.mechanics.strain import (
    BATCH,
    Aggregates,
    Gauge,
    RestShape,
    green,
    strain,
    stretches,
    symmetric_eigenvalues,
)
from tests import pictures

MESH = slab(pictures.lobed(0.08, 0.1, 3), 0.02, 0.02)
REST = RestShape(MESH)
XY = np.outer([1.0, 0, 0], [0, 1.0, 0])
seeds = st.integers(0, 10**6)


def rotation(rng: np.random.Generator) -> np.ndarray:
    """A proper rotation, evenly drawn."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.linalg.det(q)


def gradient(rng: np.random.Generator, size: float = 0.3) -> np.ndarray:
    """A deformation gradient that turns nothing inside out."""
    turn, other = rotation(rng), rotation(rng)
    return turn @ np.diag(rng.uniform(1 - size, 1 + size, 3)) @ other


def moved(F: np.ndarray, shift: tuple[float, ...] = (0.5, -0.1, 0.002)) -> np.ndarray:
    """The mesh's nodes after a homogeneous deformation."""
    return MESH.nodes @ F.T + shift


@pytest.mark.parametrize("factor", [0.7, 0.999999, 1.0, 1.3])
def test_a_uniform_stretch_is_its_factor(factor):
    F = REST.gradients(moved(factor * np.eye(3)))
    np.testing.assert_allclose(stretches(F), factor, rtol=0, atol=1e-12)
    np.testing.assert_allclose(strain(F), abs(factor - 1), rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        green(F), np.broadcast_to((factor**2 - 1) / 2 * np.eye(3), F.shape), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("factors", [(1.2, 1.0, 1.0), (0.8, 1.0, 1.0), (0.9, 0.9, 1.1), (1.1, 0.95, 0.7)])
def test_a_stretch_along_the_axes_gives_its_factors(factors):
    F = REST.gradients(moved(np.diag(factors)))
    np.testing.assert_allclose(
        stretches(F), np.broadcast_to(sorted(factors)[::-1], F.shape[:-1]), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(strain(F), max(abs(f - 1) for f in factors), rtol=0, atol=1e-12)


@pytest.mark.parametrize("shear", [1e-6, 0.01, 0.1, 0.5, 1.0])
def test_simple_shear_has_the_stretches_of_the_textbook(shear):
    """With shear g: sqrt(1 + g^2/4) +- g/2, and 1 out of the plane."""
    F = REST.gradients(moved(np.eye(3) + shear * XY))
    root = np.sqrt(1 + shear**2 / 4)
    expected = [root + shear / 2, 1.0, root - shear / 2]
    np.testing.assert_allclose(stretches(F), np.broadcast_to(expected, F.shape[:-1]), rtol=0, atol=1e-12)
    np.testing.assert_allclose(strain(F), root + shear / 2 - 1, rtol=0, atol=1e-12)


@given(seeds)
def test_a_rotation_gives_zero_but_for_its_own_rounding(seed):
    R = rotation(np.random.default_rng(seed))
    assert strain(R) <= 2e-15
    assert REST.strain(moved(R)).max() < 1e-12, "coordinates are rounded beside the size of a cell"


def test_the_undeformed_mesh_has_no_strain_at_all():
    assert strain(np.eye(3)) == 0.0
    assert REST.strain(MESH.nodes).max() < 1e-14


@given(seeds)
def test_stretches_are_the_singular_values(seed):
    F = gradient(np.random.default_rng(seed))
    expected = np.linalg.svd(F, compute_uv=False)
    np.testing.assert_allclose(stretches(F), expected, rtol=0, atol=1e-13)
    assert strain(F) == pytest.approx(np.abs(expected - 1).max(), abs=1e-13)


@given(seeds)
def test_turning_the_body_changes_nothing_and_turning_the_rest_shape_neither(seed):
    rng = np.random.default_rng(seed)
    F, turn = gradient(rng), rotation(rng)
    np.testing.assert_allclose(green(turn @ F), green(F), rtol=0, atol=1e-13)
    for other in (turn @ F, F @ turn):
        assert strain(other) == pytest.approx(strain(F), abs=1e-13)


@given(seeds, st.sampled_from([(1, 1, 1), (2, 1, 1), (2, 2, 1), (1, 0, -1), (1, 1e-9, 0)]), st.floats(-12, 3))
def test_eigenvalues_are_exact_also_where_two_or_three_are_equal(seed, values, exponent):
    turn, scale = rotation(np.random.default_rng(seed)), 10.0**exponent
    A = scale * turn @ np.diag(np.array(values, float)) @ turn.T
    found = symmetric_eigenvalues((A + A.T) / 2)
    np.testing.assert_allclose(found, scale * np.sort(values)[::-1], rtol=0, atol=2e-14 * scale)


def test_all_tetrahedra_and_samples_at_once_as_one_by_one():
    rng = np.random.default_rng(0)
    nodes = MESH.nodes + rng.normal(0, 1e-3, (3, *MESH.nodes.shape))
    together = REST.strain(nodes)
    assert together.shape == (3, len(MESH.tetrahedra))
    for s, sample in enumerate(nodes):
        a, b, c, d = (sample[MESH.tetrahedra[7, i]] for i in range(4))
        A, B, C, D = (MESH.nodes[MESH.tetrahedra[7, i]] for i in range(4))
        F = np.stack([b - a, c - a, d - a], 1) @ np.linalg.inv(np.stack([B - A, C - A, D - A], 1))
        assert together[s, 7] == pytest.approx(float(strain(F)), abs=1e-12)


def rest_with(volumes: list[float]) -> RestShape:
    """A rest shape of tetrahedra with these volumes; only the aggregates of it are used."""
    rest = RestShape(MESH)
    rest.volumes = np.array(volumes)
    return rest


def test_aggregates_of_a_body_evenly_strained_are_that_strain():
    found = REST.aggregates(np.full(len(MESH.tetrahedra), 0.07))
    for value in (found.p99, found.top10, found.maximum):
        assert value == pytest.approx(0.07, abs=1e-15)


def test_aggregates_weigh_by_volume():
    """A splinter of a thousandth of the volume is the maximum and nothing else."""
    found = rest_with([1.0, 1.0, 0.002]).aggregates(np.array([0.01, 0.02, 0.9]))
    assert found.maximum == 0.9
    assert found.p99 == 0.02
    assert found.top10 == pytest.approx((0.002 * 0.9 + 0.1982 * 0.02) / 0.2002)


def test_p99_and_top10_of_many_equal_volumes():
    found = rest_with([1.0] * 1000).aggregates(np.random.default_rng(0).permutation(1000) / 1000)
    assert found.p99 == 0.989
    assert found.top10 == pytest.approx(0.9495)
    assert found.maximum == 0.999


@given(seeds)
def test_the_more_of_the_body_an_aggregate_looks_at_the_smaller_it_is(seed):
    rng = np.random.default_rng(seed)
    found = rest_with(list(rng.uniform(0.1, 1, 300))).aggregates(rng.exponential(0.02, 300))
    assert 0 <= found.top10 <= found.maximum
    assert found.p99 <= found.maximum


def test_a_gauge_keeps_the_peak_of_each_aggregate_whenever_it_came():
    sizes = np.concatenate([np.linspace(0, 0.1, BATCH + 3), np.linspace(0.1, 0, 5)])
    gauge = Gauge(REST)
    assert not gauge.field().any()
    with pytest.raises(ValueError, match="no sample"):
        gauge.peak()
    for size in sizes:
        gauge.look(moved(np.diag([1 + size, 1, 1])))
    assert gauge.peak() == gauge.peak()
    np.testing.assert_allclose(gauge.field(), 0.1, atol=1e-12)
    assert vars(gauge.peak()) == pytest.approx(vars(Aggregates(0.1, 0.1, 0.1)))


def test_a_node_shows_its_most_strained_tetrahedron():
    values = np.random.default_rng(0).uniform(size=len(MESH.tetrahedra))
    shown = REST.at_nodes(values)
    for node in (0, 17, len(MESH.nodes) - 1):
        assert shown[node] == values[np.any(MESH.tetrahedra == node, axis=1)].max()
    assert shown.max() == values.max()
