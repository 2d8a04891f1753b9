"""The contract of states and force: the toy world keeps it, and there are ways to break it."""

from contextlib import suppress

import numpy as np
import pytest

from deformpush.checks.contract import contract
from deformpush.worlds.toy import ToyWorld

TOY = ["world=toy", "robot=tool"]


RESTORE = ToyWorld.restore


def restore_half(self, state: bytes) -> None:
    theta = self.theta
    RESTORE(self, state)
    self.theta = theta


def restore_anything(self, state: bytes) -> None:
    with suppress(ValueError):
        RESTORE(self, state)


def restore_roughly(self, state: bytes) -> None:
    RESTORE(self, state)
    self.c = self.c + 2e-3 * np.random.default_rng().normal(size=2)


def test_states_that_are_returned_to():
    found = {gate.name: gate.passed for gate in contract(TOY)}
    assert found["states"]
    assert all(found.values())


@pytest.mark.parametrize("restoring", [restore_half, restore_anything, restore_roughly])
def test_states_that_are_not(restoring, monkeypatch):
    monkeypatch.setattr(ToyWorld, "restore", restoring)
    *_, last = [(gate.name, gate.passed) for gate in contract(TOY)]
    assert last == ("states", False)


def test_a_world_without_states_is_not_asked_for_any(monkeypatch):
    monkeypatch.setattr(ToyWorld, "offers", ToyWorld.offers - {"states"})
    for name in ("save", "restore"):
        monkeypatch.delattr(ToyWorld, name)
    assert "states" not in [gate.name for gate in contract(TOY)]
    world = object.__new__(ToyWorld)
    with pytest.raises(NotImplementedError, match="ToyWorld offers no states"):
        world.save()
    with pytest.raises(NotImplementedError, match="ToyWorld offers no states"):
        world.restore(b"")


@pytest.mark.parametrize("promised", [True, False])
def test_force_is_told_as_far_as_it_is_offered(promised, monkeypatch):
    whole = ToyWorld.push

    def push(self, path):
        outcome = whole(self, path)
        if not promised:
            outcome.tool_force_peak = outcome.tool_force_mean = 1.0
        return outcome

    monkeypatch.setattr(ToyWorld, "offers", ToyWorld.offers | ({"force"} if promised else set()))
    monkeypatch.setattr(ToyWorld, "push", push)
    *_, last = contract(TOY)
    assert (last.name, last.measured) == ("push", "lacks force" if promised else "tells force")
