"""The paper's optimizer as a black box: ask, tell, ask again.

Also of `optimizer/base.py`, `optimizer/history.py`, `optimizer/design.py` and `model/error.py`.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deformpush.gp import Constant, Fixed, Matern52
from deformpush.optimizer import ABO, LCB, LHS, Adaptive, Box, Components, Random, Sobol
from deformpush.optimizer.constraint import Unconstrained

OUTER = {"kappa": (0.1, 0.9), "d": (0.01, 0.03)}


def abo(seed=0, S0=5, bounds=None, **parts):
    settings = {
        "bounds": bounds or Adaptive(**OUTER),
        "rng": np.random.default_rng(seed),
        "acquisition": LCB(w=2.0),
    }
    return ABO(parts=Components(**settings | parts), S0=S0)


def effect(u, t):
    centre = 0.5 + 0.3 * np.sin(t / 10)
    return -5 * u[1] * np.exp(-(((u[0] - centre) / 0.2) ** 2)) + 0.02


def play(opt, pushes, start=0):
    asked = []
    for t in range(start, start + pushes):
        proposal = opt.ask()
        asked.append(proposal)
        opt.tell(proposal.u, effect(proposal.u, t))
    return asked


def test_design_comes_first_then_the_model():
    opt = abo()
    asked = play(opt, 12)
    assert [p.phase for p in asked[:5]] == ["initial"] * 5
    assert {p.phase for p in asked[5:]} <= {"exploit", "explore"}
    assert np.isnan([p.acq for p in asked[:5]]).all()
    for p in asked[5:]:
        assert p.acq == pytest.approx(p.mean - 2.0 * p.std, abs=1e-12)
        assert p.phase == ("exploit" if -p.mean > p.std else "explore")
        assert {
            "rho_kappa",
            "rho_d",
            "rho_t",
            "sigma_f",
            "noise",
            "jitter",
            "evaluations",
            "on_bound",
        } <= set(p.info)


def test_asking_twice_gives_the_same_push():
    opt = abo()
    play(opt, 8)
    first = opt.ask()
    opt.maps(8)
    assert opt.ask() is first


def test_same_seed_same_pushes_bit_for_bit():
    first, second, other = (np.array([p.u for p in play(abo(seed), 15)]) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), closed=st.booleans())
def test_pushes_stay_in_their_bounds(seed, closed):
    opt = abo(seed, closed=closed)
    lo, hi = opt.parts.bounds.outer.T
    for p in play(opt, 12):
        assert (p.bounds[:, 0] < p.bounds[:, 1]).all()
        assert (p.bounds[:, 0] >= lo).all()
        assert (p.bounds[:, 1] <= hi).all()
        assert (p.u >= p.bounds[:, 0]).all()
        assert (p.u <= p.bounds[:, 1]).all()


def test_it_follows_a_moving_optimum():
    """After 30 pushes its regret is a small part of that of random pushes."""
    possible = -5 * 0.03 + 0.02
    reached = [effect(p.u, t) for t, p in enumerate(play(abo(S0=10, mean=Constant()), 60)) if t >= 30]
    rng = np.random.default_rng(0)
    random = [effect((0.1, 0.01) + rng.random(2) * (0.8, 0.02), t) for t in range(30, 60) for _ in range(20)]
    assert np.mean(reached) - possible < 0.4 * (np.mean(random) - possible)


def test_maps_cover_the_outer_bounds_and_agree_with_the_choice():
    opt = abo(bounds=Box(**OUTER), acquisition=LCB(w=1.0))
    assert opt.maps(6) == {}
    play(opt, 10)
    maps, proposal = opt.maps(41), opt.ask()
    assert {name: m.shape for name, m in maps.items()} == {"mean": (41, 41), "std": (41, 41), "acq": (41, 41)}
    np.testing.assert_allclose(maps["acq"], maps["mean"] - maps["std"], atol=1e-12)
    assert proposal.acq <= maps["acq"].min() + 1e-9
    row, column = np.unravel_index(np.argmin(maps["acq"]), (41, 41))
    nearest = np.linspace(0.1, 0.9, 41)[column], np.linspace(0.01, 0.03, 41)[row]
    assert (np.abs(proposal.u - nearest) <= (0.021, 0.0006)).all()


def test_w_zero_exploits_the_mean():
    opt = abo(acquisition=LCB(w=0.0))
    play(opt, 9)
    assert opt.ask().acq == pytest.approx(opt.ask().mean, abs=1e-15)


def test_what_was_not_asked_for_is_welcome():
    opt = abo(S0=5)
    for t in range(7):
        u = (0.2 + 0.1 * t, 0.02)
        opt.tell(u, effect(u, t))
    assert opt.ask().phase != "initial"


@pytest.mark.parametrize(
    ("u", "xi", "message"),
    [
        ((0.5, 0.02), np.nan, "finite"),
        ((0.5, 0.02), np.inf, "finite"),
        ((np.nan, 0.02), 0.1, "finite"),
        ((0.5, 0.02, 0.0), 0.1, "shape"),
        (0.5, 0.1, "shape"),
        ((0.5, 0.02), (0.1, 0.2), "shape"),
        ((0.95, 0.02), 0.1, "outside"),
        ((0.5, 0.031), 0.1, "outside"),
        (("here", 0.02), 0.1, "numbers"),
    ],
)
def test_a_bad_tell_is_refused_and_counted(u, xi, message):
    opt = abo()
    play(opt, 6)
    before = opt.ask()
    with pytest.raises(ValueError, match=message):
        opt.tell(u, xi)
    assert opt.rejected == 1
    assert opt.ask() is before


@pytest.mark.parametrize("done", [0, 3, 5, 9])
@pytest.mark.parametrize("ask_before_saving", [False, True])
def test_restored_it_goes_on_as_if_nothing_had_happened(done, ask_before_saving):
    opt = abo(seed=1)
    play(opt, done)
    if ask_before_saving:
        opt.ask()
    twin = abo(seed=99)
    twin.restore(opt.state())
    for mine, other in zip(play(opt, 6, done), play(twin, 6, done), strict=True):
        np.testing.assert_array_equal(mine.u, other.u)
        assert mine.phase == other.phase


def test_restore_refuses_what_does_not_fit():
    opt = abo(S0=5)
    with pytest.raises(ValueError, match="S0=7"):
        opt.restore(abo(S0=7).state())
    with pytest.raises(ValueError, match="outer bounds"):
        opt.restore(abo(bounds=Box(d=(0.01, 0.05))).state())


def test_closed_contours_get_a_periodic_kernel():
    assert abo(closed=True)._learner.gp.kernel.kappa == "periodic"
    assert abo(closed=False)._learner.gp.kernel.kappa == "open"
    assert abo(closed=True, kernel=Matern52(kappa="open"), fit=Fixed())._learner.gp.kernel.kappa == "open"


@pytest.mark.parametrize("S0", [1, 2, 10, 33])
def test_latin_hypercube_is_scipys(S0):
    """Point for point and bit for bit, the second design of a generator too."""
    from scipy.stats.qmc import LatinHypercube

    ours, theirs = np.random.default_rng(7), np.random.default_rng(7)
    for _ in range(2):
        np.testing.assert_array_equal(LHS().points(S0, ours), LatinHypercube(2, rng=theirs).random(S0))


@pytest.mark.parametrize("design", [LHS(), Sobol(), Random()])
@pytest.mark.parametrize("S0", [1, 7, 10])
def test_designs_fill_the_outer_bounds(design, S0):
    points = np.array([p.u for p in play(abo(S0=S0, design=design), S0)])
    assert points.shape == (S0, 2)
    unit = (points - (0.1, 0.01)) / (0.8, 0.02)
    assert ((unit >= 0) & (unit <= 1)).all()
    assert len(np.unique(points, axis=0)) == S0
    if isinstance(design, LHS):
        assert (np.sort(np.floor(unit * S0), axis=0) == np.arange(S0)[:, None]).all()


def test_asking_in_between_seldom_changes_what_is_learnt():
    """It moves the start of the search for hyper-parameters; some densities have several tops."""
    agree = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        silent, curious = abo(seed), abo(seed)
        for t in range(12):
            u = np.array([0.1, 0.01]) + rng.random(2) * (0.8, 0.02)
            if rng.random() < 0.5:
                curious.ask()
                curious.maps(4)
            for opt in (silent, curious):
                opt.tell(u, effect(u, t))
        np.testing.assert_array_equal(silent.history.U, curious.history.U)
        one, other = silent.maps(6), curious.maps(6)
        agree.append(all(np.allclose(one[n], other[n], atol=2e-4 * np.abs(one[n]).max()) for n in one))
    assert np.mean(agree) > 0.8


def test_without_a_limit_everything_is_allowed_and_nothing_changed():
    free, u = Unconstrained(), np.array([0.3, 0.5])
    objective, box = SimpleNamespace(), np.array([[0.0, 1.0], [0.0, 1.0]])
    assert free.feasible(u[None]).walled(objective) is objective
    assert free.allowed(np.zeros((3, 2))).all()
    assert free.initial(u, box) is None
    choice = free.choose(u, SimpleNamespace(), objective, box, box)
    assert (choice.u is u, choice.speed, choice.notes, choice.anywhere) == (True, None, {}, False)
    assert free.state() == {}
    assert abo().needs == frozenset()
