"""Energies of a soft sheet against closed forms and differences, and what must hold of its pushes."""

import numpy as np
import pytest
from scipy.optimize import minimize

from deformpush.mechanics import soft_push
from deformpush.mechanics.geometry import rotation
from deformpush.mechanics.soft_push import pushed
from deformpush.mechanics.soft_sheet import CREEP, HARD, Sheet
from deformpush.mechanics.triangulation import triangulate
from tests.outlines import ell, rectangle

RECT = triangulate(rectangle(0.2, 0.1), 0.03)
SOFT = Sheet.of(RECT, 30.0)
RADIUS = 0.01
TRAVEL = np.array([0.01, 0.03])
UP = np.array([0.0, 1.0])


def below(*x):
    """Discs that touch the lower long side at x, and their way."""
    return np.array([(a, -0.05 - RADIUS) for a in x]), np.tile(UP, (len(x), 1))


def push(sheet, *x):
    return pushed(sheet, sheet.rest, *below(*x), RADIUS, TRAVEL)


def middle(sheet, x):
    return np.einsum("...ai,a->...i", x, sheet.load)


def turn(sheet, x):
    """Angle that a sheet came to be turned by."""
    a, b = ((y - middle(sheet, y)[..., None, :]) @ (1, 1j) for y in (sheet.rest, x))
    return np.angle(np.sum(sheet.load * np.conj(a) * b, axis=-1))


def shaken(sheet, size, seed=0):
    return sheet.rest[None] + np.random.default_rng(seed).normal(0, size, (3, *sheet.rest.shape))


@pytest.mark.parametrize("along", [0.8, 1.0, 1.3])
def test_a_strip_that_is_stretched_has_the_energy_and_the_width_of_the_closed_form(along):
    m, lam = SOFT.lame
    across = (2 * m + lam * (2 - along)) / (2 * m + lam)  # where the stress across vanishes
    x = (SOFT.rest * (along, across) @ rotation(0.4).T)[None]
    psi = m * ((along - 1) ** 2 + (across - 1) ** 2) + lam / 2 * (along + across - 2) ** 2
    assert SOFT.elastic(x)[0] == pytest.approx(0.02 * psi, rel=1e-9, abs=1e-12)
    slope, _ = SOFT.elastic_forces(x)
    side = np.abs(np.abs(SOFT.rest[:, 0]) - 0.1) < 1e-9
    assert np.abs(slope[0, ~side]).max() < 1e-9, "only the two ends are pulled"
    assert SOFT.strain(x)[0] == pytest.approx(max(abs(along - 1), abs(across - 1)), abs=1e-9)


def test_the_load_is_spread_by_area_and_adds_up_to_1():
    for share in (0.0, 0.4):
        sheet = Sheet.of(RECT, 30.0, rim_share=share)
        assert sheet.load.sum() == pytest.approx(1)
        np.testing.assert_allclose(middle(sheet, sheet.rest), 0, atol=2e-3)
    inner = np.setdiff1d(np.arange(len(SOFT.rest)), SOFT.rim)
    assert Sheet.of(RECT, 30.0, rim_share=0.4).load[inner].sum() < 0.7 * SOFT.load[inner].sum()


def differences(energy, x, step=1e-7):
    """Slope of an energy of one sheet `(N, 2)`, by central differences."""
    slope = np.zeros_like(x)
    for i in np.ndindex(x.shape):
        up, down = x.copy(), x.copy()
        up[i] += step
        down[i] -= step
        slope[i] = (energy(up[None])[0] - energy(down[None])[0]) / (2 * step)
    return slope


def test_slopes_are_those_of_the_energies():
    was, tool = shaken(SOFT, 1e-3, 1), np.array([[0.02, -0.055]] * 3)
    x = shaken(SOFT, 2e-3)
    cases = {
        "elastic": (SOFT.elastic, SOFT.elastic_forces(x)[0]),
        "friction": (lambda y: SOFT.friction(y, was[:1]), SOFT.friction_forces(x, was)[0]),
        "contact": (lambda y: SOFT.contact(y, tool[:1], RADIUS), SOFT.contact_forces(x, tool, RADIUS)[0]),
    }
    for name, (energy, slope) in cases.items():
        np.testing.assert_allclose(slope[0], differences(energy, x[0]), atol=1e-4, err_msg=name)
        assert np.abs(slope[0]).max() > 1e-3, name


def test_second_derivatives_are_never_negative():
    x = shaken(SOFT, 8e-3)
    tool = np.array([[0.02, -0.055]] * 3)
    for second in (
        SOFT.elastic_forces(x)[1] / SOFT.e,
        SOFT.friction_forces(x, SOFT.rest[None])[1],
        SOFT.contact_forces(x, tool, RADIUS)[1] / HARD,
    ):
        np.testing.assert_allclose(second, np.swapaxes(second, -1, -2), atol=1e-12)
        assert np.linalg.eigvalsh(second).min() > -1e-12


def test_a_very_stiff_sheet_moves_as_a_rigid_body_under_the_same_friction():
    """The body has three numbers; another minimiser finds them, step by step."""
    sheet = Sheet.of(RECT, 1e4)
    (contact,), _ = below(0.04)
    was = sheet.rest

    def placed(pose):
        return sheet.rest @ rotation(pose[2] / 0.1).T + pose[:2]

    pose = np.zeros(3)
    for s in soft_push.STEP * np.arange(1, 7):
        tool = (contact + s * UP)[None]

        def energy(pose, was=was, tool=tool):
            x = placed(pose)[None]
            return float((sheet.friction(x, was[None]) + sheet.contact(x, tool, RADIUS))[0])

        options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000, "maxfev": 4000}
        pose = minimize(energy, pose, method="Nelder-Mead", options=options).x
        was = placed(pose)
    moved, turned = middle(sheet, was) - middle(sheet, sheet.rest), turn(sheet, was)
    after = push(sheet, 0.04)[0, 1]
    soft, angle = middle(sheet, after) - middle(sheet, sheet.rest), turn(sheet, after)
    assert np.linalg.norm(soft - moved) < 0.02 * np.linalg.norm(moved)
    assert abs(angle - turned) < 0.02 * abs(turned)
    assert sheet.strain(after[None]).max() < 1e-3


def test_the_tool_pushes_as_hard_as_friction_holds():
    """Straight through the middle everything slides one way: the force is mu m g, 1 here."""
    solver = soft_push._Solver(SOFT)
    contact, way = below(0.0)
    x = SOFT.rest[None]
    for s in (0.005, 0.01, 0.015, 0.02):
        was, x = x, solver.rest(x, contact + s * way, RADIUS)
    pressed = SOFT.contact_forces(x, contact + 0.02 * way, RADIUS)[0].sum(axis=1)
    held = SOFT.friction_forces(x, was)[0].sum(axis=1)
    np.testing.assert_allclose(pressed + held, 0, atol=1e-3)
    assert np.linalg.norm(held) == pytest.approx(1, abs=0.02)


def test_pushes_at_mirror_images_are_mirror_images():
    a, b = push(SOFT, -0.05, 0.05)
    mirror = np.linalg.norm(SOFT.rest[:, None] * (-1, 1) - SOFT.rest, axis=2).argmin(axis=1)
    if np.linalg.norm(SOFT.rest[mirror] * (-1, 1) - SOFT.rest, axis=1).max() < 1e-9:
        np.testing.assert_allclose(a[:, mirror] * (-1, 1), b, atol=1e-5)
    np.testing.assert_allclose(middle(SOFT, a) * (-1, 1), middle(SOFT, b), atol=5e-4)
    np.testing.assert_allclose(turn(SOFT, a), -turn(SOFT, b), atol=np.radians(0.3))


def test_the_frame_does_not_matter():
    contact, way = below(-0.03, 0.06)
    straight = pushed(SOFT, SOFT.rest, contact, way, RADIUS, TRAVEL)
    r, shift = rotation(2.1).T, np.array([0.3, -0.2])
    there = pushed(SOFT, SOFT.rest @ r + shift, contact @ r + shift, way @ r, RADIUS, TRAVEL)
    np.testing.assert_allclose(there, straight @ r + shift, atol=2e-5)


def test_a_push_does_not_depend_on_those_beside_it():
    alone = push(SOFT, 0.05)
    np.testing.assert_allclose(push(SOFT, -0.08, 0.05, 0.0)[1], alone[0], atol=1e-8)


def test_without_the_tool_a_bent_sheet_gives_back_energy_and_creeps_no_further():
    solver = soft_push._Solver(SOFT)
    bent = (SOFT.rest + 2.0 * np.stack([0 * SOFT.rest[:, 0], SOFT.rest[:, 0] ** 2], axis=1))[None]
    energies, moved = [SOFT.elastic(bent)[0]], []
    for _ in range(4):
        was, bent = bent, solver.rest(bent, None, RADIUS)
        energies.append(SOFT.elastic(bent)[0])
        moved.append(np.abs(bent - was).max())
    assert (np.diff(energies) < 1e-9).all()
    assert moved[0] > 10 * CREEP
    assert moved[-1] < CREEP


def test_smaller_cells_converge():
    places, turns = [], []
    for cell in (0.03, 0.015, 0.0075):
        sheet = Sheet.of(triangulate(rectangle(0.2, 0.1), cell), 30.0)
        after = push(sheet, 0.0, 0.05)[:, 1]
        places.append(middle(sheet, after))
        turns.append(turn(sheet, after))
    off = [float(np.linalg.norm(place - places[-1], axis=1).max()) for place in places]
    assert off[1] < 0.6 * off[0], (
        "of first order: the dent deepens, so e belongs to the mesh it was learnt with"
    )
    assert off[0] < 5e-3
    assert np.abs(np.array(turns) - turns[-1]).max() < np.radians(1.0)


def test_smaller_steps_change_little(monkeypatch):
    coarse = push(SOFT, 0.0, 0.05)[:, 1]
    monkeypatch.setattr(soft_push, "STEP", 1.25e-3)
    small = push(SOFT, 0.0, 0.05)[:, 1]
    assert np.linalg.norm(middle(SOFT, coarse) - middle(SOFT, small), axis=1).max() < 1e-3
    assert np.abs(turn(SOFT, coarse) - turn(SOFT, small)).max() < np.radians(0.6)


def test_an_outline_that_is_not_convex_can_be_pushed_too():
    sheet = Sheet.of(triangulate(ell(0.16, 0.05), 0.025), 50.0)
    low = sheet.rest[:, 1].min()
    after = pushed(sheet, sheet.rest, np.array([[0.0, low - RADIUS]]), UP[None], RADIUS, TRAVEL)
    assert middle(sheet, after[0, 1])[1] > 0.005
    assert np.isfinite(after).all()
    assert (np.linalg.det(sheet.stretch(after[0])) > 0.2).all()
