"""Pushes under a limit: what is allowed, and that it is kept to."""

import numpy as np
import pytest

from deformpush.optimizer import ABO, Adaptive, Components
from deformpush.optimizer.acquisition import LCB
from deformpush.optimizer.safe import Safe

from .fragile_cases import CAREFUL, GAIN, MADE_OF, OUTER, D, optimizer, peak, state, xi


def pushed(optimizer, n: int) -> list[float]:
    """Make n pushes; their peaks."""
    peaks, now = [], state()
    for _ in range(n):
        u = optimizer.ask(now).u
        then = state(peak(u))
        optimizer.tell(u, xi(u), now, then)
        peaks.append(then.strain)
        now = then
    return peaks


def learnt(n: int = 8, **settings):
    """A strain model after n pushes, and the pushes in model coordinates."""
    model = Safe(limit=0.1, fit=CAREFUL, **settings).constraint(MADE_OF)
    U = np.random.default_rng(1).uniform(0, 1, (n, 2))
    for u in U:
        model.keep((peak((u[0], D[0] + u[1] * (D[1] - D[0]))), 0.0))
    return model, U


def test_the_gradient_is_that_of_the_constraint():
    model, U = learnt()
    safe_set = model.feasible(U)
    at = np.random.default_rng(2).uniform(0.05, 0.95, (20, 2))
    value, slope = safe_set.gradient(at)
    np.testing.assert_allclose(value, safe_set.constraint(at))
    for j in range(2):
        step = np.eye(2)[j] * 1e-6
        numeric = (safe_set.constraint(at + step) - safe_set.constraint(at - step)) / 2e-6
        np.testing.assert_allclose(slope[:, j], numeric, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("p_safe", [0.8, 0.95, 0.99])
def test_allowed_means_probable_enough(p_safe):
    model, U = learnt(p_safe=p_safe)
    safe_set = model.feasible(U)
    for u in np.random.default_rng(3).uniform(0, 1, (50, 2)):
        assert (safe_set.constraint(u[None])[0] <= 0) == (safe_set.probability(u, 0.0) >= p_safe)


def test_the_probability_counts_what_a_repeated_push_would_scatter():
    model, U = learnt(n=40)
    safe_set = model.feasible(U)
    assert safe_set.noise > 0
    mu, _ = safe_set.peak(U[:1])
    _, sigma = safe_set.learnt.predict(U[:1], safe_set.trend.basis(1, 0.0))
    assert safe_set.constraint(U[:1])[0] == pytest.approx(
        mu[0] + safe_set.z * np.hypot(sigma[0], safe_set.noise) - np.log(0.1)
    )


def test_before_the_first_push_nothing_is_known_and_the_shortest_is_made():
    asked = optimizer(Safe(limit=0.1, fit=CAREFUL)).ask(state())
    assert asked.u[1] == D[0]
    assert asked.info["no_safe_push"] == 1.0
    assert np.isnan(asked.info["p_safe"])


def test_pushes_grow_outward_from_gentle_ones_and_stay_under_the_limit():
    plain, safe = (
        [pushed(optimizer(acquisition, seed), 40) for seed in range(4)]
        for acquisition in (LCB(), Safe(limit=0.1, fit=CAREFUL))
    )
    assert np.mean([np.mean(np.array(peaks) > 0.1) for peaks in plain]) > 0.3
    assert np.mean([np.mean(np.array(peaks) > 0.1) for peaks in safe]) <= 0.02
    for peaks in safe:
        assert max(peaks) > 0.075, "it goes near the limit"


def test_the_map_of_the_acquisition_is_open_where_pushes_are_allowed():
    safe = optimizer(Safe(limit=0.1, fit=CAREFUL))
    pushed(safe, 12)
    acq = safe.maps(24)["acq"]
    kappa, d = np.meshgrid(np.linspace(0, 1, 24), np.linspace(0, 1, 24))
    open_ = safe._know(None).feasible.constraint(np.column_stack([kappa.ravel(), d.ravel()])) <= 0
    assert 0 < open_.sum() < open_.size
    np.testing.assert_array_equal(np.isfinite(acq).ravel(), open_)
    assert np.ptp(acq[np.isfinite(acq)]) < 10.0, "the wall is not on it"


def test_what_the_camera_sees_serves_as_well():
    safe = optimizer(
        Safe(
            limit=0.1,
            signal="contour",
            contour_gain=GAIN,
            contour_scatter=0.0,
            contour_places=0.35,
            fit=CAREFUL,
        )
    )
    peaks = np.array(pushed(safe, 30))
    assert np.mean(peaks > 0.1) <= 0.04


def difference_between_places(signal: str) -> float:
    """What a strain model makes of two places where the peaks of two pushes each differ, as a share of that."""
    model = Safe(limit=0.1, fit=CAREFUL, signal=signal, contour_scatter=0.3).constraint(MADE_OF)
    U = np.array([[0.3, 0.0], [0.7, 0.0]])
    for which in [0, 1] * 2:
        model.keep((0.06 if which else 0.08, 0.0))
    mu, _ = model.feasible(np.tile(U, (2, 1))).peak(U)
    return float((mu[0] - mu[1]) / np.log(0.08 / 0.06))


def test_places_are_told_apart_by_strain_and_not_by_dents():
    assert difference_between_places("strain") > 0.9
    assert abs(difference_between_places("contour")) < 0.1


@pytest.mark.parametrize("helps", [True, False])
def test_where_nothing_is_allowed_the_gentlest_push_that_helps_is_made_and_says_so(helps):
    safe = optimizer(Safe(limit=0.001, fit=CAREFUL), S0=3)
    now = state()
    for k in range(12):
        asked = safe.ask(now)
        assert asked.u[1] == D[0]
        assert asked.info["no_safe_push"] == 1.0
        assert k == 0 or asked.info["p_safe"] < 0.95
        then = state(peak(asked.u))
        safe.tell(asked.u, xi(asked.u) if helps else 0.3 + 0.01 * asked.u[0], now, then)
        now = then
    gentlest = min(asked.u[0], 1 - asked.u[0]) < 0.15  # the lowest peak of all is at kappa = 0
    if helps:
        assert asked.mean < 0.0, "though the gentlest of all would lead away from the goal"
        assert not gentlest
    else:
        assert gentlest


@pytest.mark.parametrize(("noise", "made"), [(0.01, 0), (0.1, 1)])
def test_of_pushes_that_are_as_gentle_as_can_be_told_the_most_helpful_is_made(noise, made):
    shortest = np.array([[0.2, 0.0], [0.5, 0.0], [0.8, 0.0], [0.9, 0.0]])
    over, mean = np.array([0.30, 0.35, 0.60, 0.0]), np.array([-0.1, -0.2, -0.9, 0.1])
    now = SimpleNamespace(
        safe_set=SimpleNamespace(shortest=lambda box: (shortest, over), noise=noise),
        belief=SimpleNamespace(surface=SimpleNamespace(predict=lambda U: (mean, np.ones(4)))),
    )
    note = {"no_safe_push": 1.0}
    u, held = ABO._elsewhere(now, shortest[3], note, OUTER)
    assert (u.tolist(), held) == (shortest[made].tolist(), note)


def test_of_the_shortest_pushes_it_is_known_what_is_expected():
    model, U = learnt(n=3)
    safe_set = model.feasible(U)
    shortest, over = safe_set.shortest(np.array([[0.0, 1.0], [0.0, 1.0]]))
    assert (shortest[:, 1] == 0).all()
    np.testing.assert_allclose(over, safe_set.peak(shortest)[0] - np.log(0.1))
    assert (safe_set.constraint(shortest) > 0)[over <= 0].any(), "it goes beyond what is allowed"


def test_where_no_allowed_push_helps_any_more_it_begins_elsewhere():
    """Pushes about kappa = 0.45 help until the object has passed its goal; then only the far side does."""
    safe = optimizer(
        Safe(
            limit=0.1,
            signal="contour",
            contour_gain=GAIN,
            contour_scatter=0.25,
            contour_places=0.35,
            fit=CAREFUL,
        )
    )
    now, asked = state(), []
    for k in range(30):
        proposal = safe.ask(now)
        then = state(0.8 * peak(proposal.u))
        safe.tell(proposal.u, xi(proposal.u) if k < 12 else -xi(proposal.u), now, then)
        asked.append(proposal)
        now = then
    begun = [k for k, one in enumerate(asked) if "begun_elsewhere" in one.info]
    assert begun
    assert all(asked[k].u[1] == D[0] and asked[k].mean < 0.0 for k in begun)
    kappa = np.array([one.u[0] for one in asked])
    assert np.abs((kappa[-4:] - 0.95 + 0.5) % 1 - 0.5).max() < 0.25, "it pushes from the other side"


def test_the_wall_leaves_what_is_allowed_alone():
    model, U = learnt()
    safe_set = model.feasible(U)

    class Plane:
        def value(self, U):
            return U[:, 0] - 2.0 * U[:, 1]

        def gradient(self, U):
            return self.value(U), np.tile([1.0, -2.0], (len(U), 1))

    walled = Walled(Plane(), safe_set)
    at = np.random.default_rng(4).uniform(0, 1, (200, 2))
    allowed = safe_set.constraint(at) <= 0
    assert 0 < allowed.sum() < 200
    np.testing.assert_array_equal(walled.value(at)[allowed], Plane().value(at)[allowed])
    assert (walled.value(at)[~allowed] > Plane().value(at)[~allowed]).all()
    for got, plain in zip(walled.gradient(at), Plane().gradient(at), strict=True):
        np.testing.assert_array_equal(got[allowed], plain[allowed])


def test_it_goes_on_elsewhere_as_it_would_have_here():
    here, there = (optimizer(Safe(limit=0.1, fit=CAREFUL)) for _ in range(2))
    pushed(here, 9)
    there.restore(here.state())
    now = state(0.05)
    np.testing.assert_array_equal(here.ask(now).u, there.ask(now).u)
    assert pushed(here, 4) == pushed(there, 4)


def test_it_works_within_adaptive_bounds():
    parts = Components(
        bounds=Adaptive(d=D),
        rng=np.random.default_rng(0),
        closed=True,
        acquisition=Safe(limit=0.1, fit=CAREFUL),
    )
    peaks = pushed(ABO(S0=5, parts=parts), 30)
    assert np.mean(np.array(peaks) > 0.1) <= 0.04


def test_what_is_missing_is_said():
    with pytest.raises(ValueError, match=r"^limit: safe_lcb needs one; this object's strain_limit is null"):
        Safe(limit=None)
    with pytest.raises(ValueError, match=r"^speed: \[0.2, 0.1\] must be \[slowest, fastest\]"):
        Safe(limit=0.1, speed=(0.2, 0.1))
    safe = optimizer(Safe(limit=0.1))
    u = safe.ask(state()).u
    with pytest.raises(ValueError, match=r"^tell: the peak of the push is nan, safe_lcb needs"):
        safe.tell(u, -0.1, state(), state())
    with pytest.raises(ValueError, match=r"^tell: safe_lcb learns from states"):
        safe.tell(u, -0.1)
    assert len(safe.history) == 0
