"""The contract of states and force: a toy world that keeps it, and the ways to break it."""

import pickle

import numpy as np
import pytest

from deformpush.checks.contract import contract
from deformpush.worlds.toy import ToyWorld

TOY = ["world=toy", "robot=tool"]


def save(self) -> bytes:
    return b"toy" + pickle.dumps((self.c, self.theta))


def restore(self, state: bytes) -> None:
    if not state.startswith(b"toy"):
        raise ValueError("no state of a toy")
    self.c, self.theta = pickle.loads(state[3:])


def restore_half(self, state: bytes) -> None:
    if not state.startswith(b"toy"):
        raise ValueError("no state of a toy")
    self.c, _ = pickle.loads(state[3:])


def restore_anything(self, state: bytes) -> None:
    if state.startswith(b"toy"):
        restore(self, state)


def restore_roughly(self, state: bytes) -> None:
    restore(self, state)
    self.c = self.c + 2e-3 * np.random.default_rng().normal(size=2)


@pytest.fixture
def toy(monkeypatch):
    """Offer states, kept in this way."""

    def toy(restoring) -> dict[str, bool]:
        monkeypatch.setattr(ToyWorld, "offers", ToyWorld.offers | {"states"})
        monkeypatch.setattr(ToyWorld, "save", save)
        monkeypatch.setattr(ToyWorld, "restore", restoring)
        return {gate.name: gate.passed for gate in contract(TOY)}

    return toy


def test_states_that_are_returned_to(toy):
    found = toy(restore)
    assert found["states"]
    assert all(found.values())


@pytest.mark.parametrize("restoring", [restore_half, restore_anything, restore_roughly])
def test_states_that_are_not(restoring, toy):
    *_, last = toy(restoring).items()
    assert last == ("states", False)


def test_a_world_without_states_is_not_asked_for_any():
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
