"""The rivals keep the same contract: inside the bounds, repeatable, restorable."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from deformpush.optimizer import CMAES, BoTorch, Box, Components, Greedy, OptunaGP, RandomPush
from deformpush.optimizer.storage import load, save

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


def rectangle(theta=0.0, c=(0.5, 0.0), n=120):
    """A 0.2 x 0.1 m outline, counter-clockwise, evenly spaced, at a pose."""
    corners = np.array([[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05], [-0.1, -0.05]])
    length = np.r_[0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))]
    s = np.arange(n) / n * length[-1]
    points = np.stack([np.interp(s, length, corners[:, i]) for i in range(2)], axis=1)
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    return points @ turn.T + c


def state(goal, turn, theta=0.0, c=(0.5, 0.0)):
    contour = rectangle(theta, c)
    return SimpleNamespace(
        contour=contour,
        c=np.array(c),
        theta=theta,
        effective=contour,
        goal_c=np.array(c) + goal,
        goal_theta=theta + turn,
    )


@pytest.mark.parametrize("theta", [0.0, 0.7, 2.5])
@pytest.mark.parametrize("goal", [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)])
def test_greedy_pushes_towards_the_goal_through_the_centroid(goal, theta):
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    now = state(turn @ goal, 0.0, theta)
    u = Greedy(parts=parts(closed=True)).ask(now).u
    point = turn.T @ (now.effective[round(u[0] * 120) % 120] - now.c)
    np.testing.assert_allclose(point, -np.sign(goal) * (0.1, 0.05), atol=0.006)
    assert u[1] == 0.03


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_greedy_pushes_off_centre_to_turn(turn):
    now = state((0.2, 0.0), turn)
    u = Greedy(parts=parts(closed=True)).ask(now).u
    x, y = now.effective[round(u[0] * 120) % 120] - now.c
    assert x == pytest.approx(-0.1, abs=0.006)
    # A push along +x below the centroid turns counter-clockwise.
    assert y * turn < -0.005


def test_greedy_slows_down_near_the_goal_and_needs_eyes():
    assert Greedy(parts=parts(closed=True)).ask(state((0.015, 0.0), 0.0)).u[1] == pytest.approx(0.015)
    with pytest.raises(ValueError, match="ask\\(state\\)"):
        Greedy(parts=parts()).ask()
