"""The rivals keep the same contract: inside the bounds, repeatable, restorable."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from deformpush.cell.push import Push
from deformpush.mechanics.geometry import rotation
from deformpush.mechanics.rounding import lowest
from deformpush.optimizer import ABO, CMAES, BoTorch, Box, Components, Greedy, OptunaGP, Oracle, RandomPush
from deformpush.record.checkpoint import load, save
from tests.states import BODY, TARGET, known, observed, seen

pytestmark = pytest.mark.filterwarnings("ignore")


def parts(seed=0, **kwargs):
    return Components(bounds=Box(d=(0.01, 0.03)), rng=np.random.default_rng(seed), **kwargs)


RIVALS = {
    "random": lambda seed: RandomPush(parts=parts(seed)),
    "cmaes": lambda seed: CMAES(parts=parts(seed)),
    "optuna": lambda seed: OptunaGP(parts=parts(seed), S0=4),
    "botorch": lambda seed: BoTorch(parts=parts(seed), S0=4, restarts=2, raw_samples=16),
    "botorch_default": lambda seed: BoTorch(
        parts=parts(seed), S0=4, kernel="default", restarts=2, raw_samples=16
    ),
}
EXTRA = {"cmaes": "cmaes", "optuna": "optuna", "botorch": "botorch", "botorch_default": "botorch"}


def made(name, seed):
    if name in EXTRA:
        pytest.importorskip(EXTRA[name], reason="extra `rivals` is not installed")
    return RIVALS[name](seed)


def effect(u):
    return -0.1 * np.exp(-(((u[0] - 0.3) / 0.2) ** 2)) * u[1] / 0.03


def play(opt, pushes):
    asked = []
    for _ in range(pushes):
        proposal = opt.ask()
        assert opt.ask() is proposal
        asked.append(proposal.u)
        opt.tell(proposal.u, effect(proposal.u))
    return np.array(asked)


@pytest.mark.parametrize("name", RIVALS)
def test_contract(name):
    first = play(made(name, 1), 9)
    np.testing.assert_array_equal(first, play(made(name, 1), 9))
    assert not np.array_equal(first, play(made(name, 2), 9))
    assert (first >= (0.0, 0.01)).all()
    assert (first <= (1.0, 0.03)).all()


@pytest.mark.parametrize("name", RIVALS)
def test_saved_and_restored(name, tmp_path):
    opt, twin = made(name, 3), made(name, 77)
    play(opt, 7)
    save(tmp_path / "state.npz", opt.state())
    twin.restore(load(tmp_path / "state.npz"))
    np.testing.assert_array_equal(play(opt, 3), play(twin, 3))


def test_cmaes_converges():
    assert np.abs(play(made("cmaes", 0), 120)[-10:, 0] - 0.3).max() < 0.1


def test_a_missing_library_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cmaes", None)
    with pytest.raises(ValueError, match=r"cmaes is not installed; pip install 'deformpush\[rivals\]'"):
        CMAES(parts=parts())


BARE = Push(offset=2e-4, augment="radial", tool_radius=1e-4, contact_margin=0.0, clearance=1e-4)
"""The effective contour is the object's own."""


def state(goal, turn, theta=0.0, c=(0.5, 0.0)):
    """A 0.2 x 0.1 m rectangle at a pose, its goal this far away."""
    c = np.array(c)
    at = observed(BODY @ rotation(theta).T + c, c, theta)
    return replace(known(at, target=replace(TARGET, c=c + goal, theta=theta + turn)), layout=BARE)


def place(now, u):
    """Where push u meets the contour, seen from the centroid."""
    return now.effective.points[lowest(np.abs(now.effective.kappa - u[0]))] - now.seen.c


@pytest.mark.parametrize("theta", [0.0, 0.7, 2.5])
@pytest.mark.parametrize("goal", [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)])
def test_greedy_pushes_towards_the_goal_through_the_centroid(goal, theta):
    turn = rotation(theta)
    now = state(turn @ goal, 0.0, theta)
    u = Greedy(parts=parts(closed=True)).ask(now).u
    point = turn.T @ place(now, u)
    np.testing.assert_allclose(point, -np.sign(goal) * (0.1, 0.05), atol=0.006)
    assert u[1] == 0.03


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_greedy_pushes_off_centre_to_turn(turn):
    now = state((0.2, 0.0), turn)
    u = Greedy(parts=parts(closed=True)).ask(now).u
    x, y = place(now, u)
    assert x == pytest.approx(-0.1, abs=0.006)
    # A push along +x below the centroid turns counter-clockwise.
    assert y * turn < -0.005


def test_greedy_slows_down_near_the_goal_and_needs_eyes():
    assert Greedy(parts=parts(closed=True)).ask(state((0.015, 0.0), 0.0)).u[1] == pytest.approx(0.015)
    with pytest.raises(ValueError, match="ask\\(state\\)"):
        Greedy(parts=parts()).ask()


def test_the_oracle_makes_the_push_that_a_copy_of_the_world_found_best():
    """Which fails for some, and is lowest about kappa = 0.3, d = 0.02."""
    tried = []

    def e_T_after(U):
        tried.append(U)
        e_T = (U[:, 0] - 0.3) ** 2 + (50.0 * (U[:, 1] - 0.02)) ** 2
        return np.where(U[:, 0] == 0.5, np.nan, e_T)

    oracle = Oracle(parts=parts(closed=True), kappas=10, distances=2, refined=20)
    assert oracle.needs == {"branches"}
    oracle.attach(SimpleNamespace(e_T_after=e_T_after))
    asked = oracle.ask(seen())
    every, near = tried
    assert (len(every), len(near)) == (20, 20)
    best = np.vstack(tried)[np.nanargmin(np.concatenate([e_T_after(every), e_T_after(near)]))]
    np.testing.assert_array_equal(asked.u, best)
    assert np.all(np.abs(asked.u - (0.3, 0.02)) < (0.05, 0.005))
    assert asked.info["trials"] == 40


def test_the_oracle_says_that_it_needs_a_world():
    with pytest.raises(ValueError, match=r"^ask: optimizer=oracle .* attach\(branches\)"):
        Oracle(parts=parts()).ask(seen())


def test_who_learns_nothing_uses_the_bounds_alone():
    assert RandomPush.uses == Greedy.uses == Oracle.uses == CMAES.uses == {"bounds"}
    assert BoTorch.uses == OptunaGP.uses == {"bounds", "design"}
    assert ABO.uses == {"bounds", "kernel", "mean", "fit", "model", "acquisition", "minimiser", "design"}
