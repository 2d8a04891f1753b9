"""The motion model behind ask and tell: it sees, learns, foretells, keeps and is careful.

Also of `model/motion_posterior.py` and `model/outcomes.py`.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from deformpush.mechanics.geometry import rotation
from deformpush.model.coordinates import grid_over
from deformpush.model.error_of_motion import pose
from deformpush.model.motion import MotionModel
from deformpush.model.motion_posterior import GRID, information
from deformpush.model.outcomes import MotionSurface
from deformpush.model.rigid_push import Experience, RigidPush
from deformpush.optimizer import ABO, EI, LCB, PI, Adam, Box, Components, Thompson, Zero
from deformpush.record.checkpoint import load, save
from tests.states import seen

WORLD = Experience(RigidPush(slip=(0.004, 0.001), pressure_radius=(1.1, 1.1)), 0.03, 300)
OUTER = np.array([[0.0, 1.0], [0.01, 0.03]])


def optimizer(S0=0, **parts):
    usual = {
        "bounds": Box(d=(0.01, 0.03)),
        "model": MotionModel(samples=32),
        "mean": RigidPush(lines=64),
        "acquisition": LCB(0.5),
        "minimiser": Adam(screened=128, starts=4, steps=10, polish=False),
    }
    return ABO(parts=Components(**usual | parts, rng=np.random.default_rng(0), closed=True), S0=S0)


def push(state, u):
    """What the world does: a rigid body with a slip of its own."""
    dx, dy, turn = WORLD.field(state, OUTER, True).at(np.array([[u[0], (u[1] - 0.01) / 0.02]]))[0][0]
    x, y = state.seen.c + rotation(state.seen.theta) @ (dx, dy)
    return seen(x, y, state.seen.theta + turn)


def play(opt, state, pushes):
    proposals = []
    for _ in range(pushes):
        proposals.append(opt.ask(state))
        after = push(state, proposals[-1].u)
        opt.tell(proposals[-1].u, e_T(after) - e_T(state), state, after)
        state = after
    return proposals, state


def posterior(opt, state):
    return opt._learner.posterior(opt._tried, opt.history.xi, state)


def e_T(state):
    return state.total_error(*pose(state))


def test_it_arrives_in_about_distance_over_d_max():
    _, state = play(optimizer(), seen(), 9)
    assert np.linalg.norm(state.seen.c - state.target.c) < 0.01
    assert abs(state.seen.theta) < np.radians(5)


def test_what_it_foretells_comes_true_once_it_has_learnt():
    opt = optimizer()
    _, state = play(opt, seen(0.05, 0.0, 0.5), 6)
    proposal = opt.ask(state)
    after = push(state, proposal.u)
    off = np.abs(pose(after) - proposal.forecast.mean)
    assert np.all(off < (0.003, 0.003, 0.05, 0.005))
    assert proposal.mean == pytest.approx(e_T(after) - e_T(state), abs=0.05)
    assert np.linalg.eigvalsh(proposal.forecast.cov).min() > 0


def test_what_is_learnt_at_one_pose_holds_at_another():
    opt = optimizer(mean=Zero(), S0=1)
    play(opt, seen(), 8)
    here, there = seen(0.0, 0.1, 0.0), seen(-0.05, 0.12, 2.0)
    U = np.random.default_rng(1).random((20, 2))
    means = [posterior(opt, s).outcomes.predict(U)[0] for s in (here, there)]
    np.testing.assert_allclose(*means, atol=1e-12)


@pytest.mark.parametrize("acquisition", [LCB(2.0), EI(), PI(), Thompson(features=64)])
def test_every_acquisition_works_on_it(acquisition):
    proposals, state = play(optimizer(acquisition=acquisition), seen(), 4)
    assert all(np.isfinite([p.acq, p.mean, p.std]).all() for p in proposals)
    assert e_T(state) < e_T(seen())


def test_two_pushes_ahead_arrives_too():
    _, state = play(optimizer(model=MotionModel(samples=32, lookahead=2)), seen(0.0, 0.05, 0.6), 10)
    assert np.linalg.norm(state.seen.c - state.target.c) < 0.01
    assert abs(state.seen.theta) < np.radians(5)


def test_at_the_goal_no_push_helps_and_it_says_so():
    opt = optimizer()
    _, state = play(opt, seen(), 4)
    goal = seen(0.0, 0.2, 0.0, 0.0)
    proposal = opt.ask(goal)
    assert proposal.mean > 0
    assert proposal.phase == "explore"
    assert proposal.info["no_help_expected"] == 1.0
    assert state.seen.c[1] > 0.05


def test_a_push_that_explores_at_the_price_of_harm_is_replaced():
    """With a large w the bound prefers uncertain pushes; what is made must lower the expected error."""
    opt = optimizer(acquisition=LCB(1000.0))
    proposals, _ = play(opt, seen(0.0, 0.17, 0.1), 3)
    assert any("harm_avoided" in p.info for p in proposals)
    assert all(p.mean < 0 for p in proposals if "no_help_expected" not in p.info)


def test_overshoot_is_answered_from_the_other_side():
    opt = optimizer()
    play(opt, seen(), 5)
    proposal = opt.ask(seen(0.0, 0.23, 0.0))
    (path,) = seen(0.0, 0.23, 0.0).paths(proposal.u[None])
    assert path.direction[1] < -0.9


@pytest.mark.parametrize("told", [0, 1, 5])
def test_a_restored_one_asks_for_the_same_push(told, tmp_path):
    opt = optimizer()
    _, state = play(opt, seen(), told)
    save(tmp_path / "state.npz", opt.state())
    again = optimizer()
    again.restore(load(tmp_path / "state.npz"))
    wanted, got = opt.ask(state), again.ask(state)
    np.testing.assert_array_equal(wanted.u, got.u)
    assert (wanted.acq, wanted.mean, wanted.std) == (got.acq, got.mean, got.std)


def test_it_must_see():
    opt = optimizer()
    with pytest.raises(ValueError, match=r"ask\(state\)"):
        opt.ask()
    with pytest.raises(ValueError, match=r"tell\(u, xi, before, after\)"):
        opt.tell([0.5, 0.02], -0.1)
    here = seen()
    lost = replace(here, seen=replace(here.seen, theta=np.nan))
    with pytest.raises(ValueError, match="not finite"):
        opt.tell([0.5, 0.02], -0.1, seen(), lost)
    assert len(opt.history) == len(opt._learner.Y) == 0


def test_a_refused_tell_leaves_nothing_behind():
    opt = optimizer()
    with pytest.raises(ValueError, match="outside the bounds"):
        opt.tell([0.5, 0.2], -0.1, seen(), seen(0.01))
    assert len(opt.history) == len(opt._learner.Y) == len(opt._learner.rigid.distances) == 0


def test_without_a_prior_it_needs_a_sample():
    with pytest.raises(ValueError, match="S0: 0 is too few"):
        optimizer(mean=Zero(), S0=0)


def test_maps_show_xi_over_the_outer_bounds():
    opt = optimizer()
    play(opt, seen(), 3)
    maps = opt.maps(8)
    assert {name: m.shape for name, m in maps.items()} == dict.fromkeys(("mean", "std", "acq"), (8, 8))
    np.testing.assert_allclose(maps["acq"], maps["mean"] - 0.5 * maps["std"], atol=1e-12)


def learnt(told=6, **parts):
    opt = optimizer(**parts)
    return posterior(opt, play(opt, seen(0.03, 0.02, 0.4), told)[1])


@dataclass
class Mu:
    surface: Any

    def value(self, U):
        return self.surface.predict(U)[0]

    def gradient(self, U):
        mu, _, dmu, _ = self.surface.gradient(U)
        return mu, dmu


@pytest.mark.parametrize("what", ["xi", "two ahead", "one draw"])
def test_slopes_over_pushes_are_those_of_finite_differences(what):
    known = learnt(model=MotionModel(samples=32, lookahead=2 if what == "two ahead" else 1))
    surface = known.surface.draw(64, np.random.default_rng(0)) if what == "one draw" else Mu(known.surface)
    U = np.random.default_rng(2).uniform(0.05, 0.95, (12, 2))
    value, slope = surface.gradient(U)
    np.testing.assert_allclose(surface.value(U), value, rtol=1e-9, atol=1e-12)
    for k in range(2):
        step = np.eye(2)[k] * 1e-7
        rise = (surface.value(U + step) - surface.value(U - step)) / 2e-7
        close = np.isclose(slope[:, k], rise, rtol=2e-3, atol=2e-3 * np.abs(slope[:, k]).max())
        assert close.mean() > 0.8  # the prior mean is bilinear: a few steps cross one of its kinks


def test_short_pushes_are_expected_to_do_little():
    outcomes = learnt(told=0).outcomes
    _, std = outcomes.predict(np.array([[0.3, 0.0], [0.3, 1.0]]))
    np.testing.assert_allclose(std[0] / std[1], 1 / 3)
    assert outcomes.noise.shape == (4,)


def test_the_most_informative_push_is_one_that_may_help():
    goal = seen(0.0, 0.2, 0.0, 0.0)
    opt = optimizer()
    play(opt, seen(0.03, 0.02, 0.4), 6)
    at_goal = posterior(opt, goal)
    box = np.array([[0.0, 1.0], [0.0, 1.0]])
    u, notes = at_goal.instead(np.array([0.5, 1.0]), box)
    assert notes == {"no_help_expected": 1.0}
    grid = grid_over(box, *GRID)
    mu, sigma = at_goal.surface.predict(grid)
    hopeful = mu - 2 * sigma < 0
    told = information(at_goal.outcomes, grid)
    if hopeful.any():
        assert information(at_goal.outcomes, u[None])[0] == told[hopeful].max()
    assert told.min() >= 0


def test_maps_are_those_of_the_acquisition_and_predicted_once(monkeypatch):
    opt, state = optimizer(model=MotionModel(samples=8, lookahead=2)), seen()
    _, state = play(opt, state, 3)
    opt.ask(state)
    known, predict, asked = opt._know(state), MotionSurface.predict, []
    wanted = known.objective.value(grid_over(np.array([[0.0, 1.0], [0.0, 1.0]]), 6, 6))
    monkeypatch.setattr(MotionSurface, "predict", lambda self, U: asked.append(len(U)) or predict(self, U))
    maps = opt.maps(6)
    np.testing.assert_array_equal(maps["acq"], maps["mean"] - 0.5 * maps["std"])
    np.testing.assert_allclose(np.sort(maps["acq"].ravel()), np.sort(wanted), atol=1e-12)
    assert asked == [36]
