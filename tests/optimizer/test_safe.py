"""Pushes under a limit: that it is kept to, whatever is minimised under it.

Also of `optimizer/constraint.py`.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from deformpush.optimizer import ABO, EI, LCB, PI, Adaptive, Components, Safe, SafeLCB, Thompson

from .fragile_cases import CAREFUL, GAIN, D, optimizer, peak, state, xi


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


@pytest.mark.parametrize("inner", [EI(), PI(), Thompson(features=64)], ids=str)
def test_any_acquisition_keeps_to_the_limit(inner):
    peaks, careless = (
        np.array(pushed(optimizer(acquisition), 30)) for acquisition in (Safe(0.1, inner, fit=CAREFUL), inner)
    )
    assert np.mean(peaks > 0.1) <= 0.04
    assert peaks.max() > 0.075, "it goes near the limit"
    assert np.mean(careless > 0.1) > 0.1


@dataclass(frozen=True)
class Filming(LCB):
    """One that needs something of the world itself."""

    @property
    def needs(self):
        return frozenset({"film"})


def test_it_needs_what_it_measures_by_and_what_the_inner_one_needs():
    assert Safe(0.1).needs == {"strain"}
    assert Safe(0.1, signal="contour").needs == optimizer(Safe(0.1, signal="contour")).needs == {"film"}
    assert Safe(0.1, Filming()).needs == {"strain", "film"}
    assert optimizer(LCB()).needs == frozenset()


def test_around_lcb_its_weight_may_be_given_directly():
    assert SafeLCB(limit=0.1, w=1.5).inner == LCB(w=1.5)
    assert replace(SafeLCB(limit=0.1, w=1.5), w=0.5).inner == LCB(w=0.5)


def test_what_is_missing_is_said():
    with pytest.raises(
        ValueError, match=r"^limit: a safe acquisition needs one; this object's strain_limit is null"
    ):
        Safe(limit=None)
    with pytest.raises(ValueError, match=r"^speed: \[0.2, 0.1\] must be \[slowest, fastest\]"):
        Safe(limit=0.1, speed=(0.2, 0.1))
    safe = optimizer(Safe(limit=0.1))
    u = safe.ask(state()).u
    with pytest.raises(ValueError, match=r"^tell: the peak of the push is nan, a safe acquisition needs"):
        safe.tell(u, -0.1, state(), state())
    with pytest.raises(ValueError, match=r"^tell: a safe acquisition learns from states"):
        safe.tell(u, -0.1)
    assert len(safe.history) == 0
