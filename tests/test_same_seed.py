"""A seed means the same everywhere: the same states and pushes, whatever kernels the libraries choose."""

import pytest

from tests.same_seed import first_difference, lines_under

TOY = ("world=toy", "robot=tool")
THREE = ("Nehalem", "generic", "numpy plain")


@pytest.mark.parametrize("optimizer", ["abo", "abo_motion"])
def test_runs_in_the_toy_world_are_identical(optimizer):
    """Told apart by 1e-16 before anything was rounded: at push 1."""
    overrides = (*TOY, f"optimizer={optimizer}", "seed=1")
    usual, plain = (lines_under(setting, 14, overrides) for setting in ("as it is", "Nehalem"))
    assert len(usual) > 6
    assert first_difference(usual, plain) is None


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("optimizer=abo_motion",),
        ("experiment=fish_straight", "acquisition=safe_lcb", "optimizer=abo_motion"),
        ("world=mujoco", "optimizer=abo_motion"),
    ],
    ids=["default", "abo_motion", "safe_lcb", "mujoco"],
)
def test_runs_in_the_engine_are_identical(overrides):
    pushes = 4 if overrides[:1] == ("experiment=fish_straight",) else 16
    usual = lines_under("as it is", pushes, overrides)
    for setting in THREE:
        assert first_difference(usual, lines_under(setting, pushes, overrides)) is None, setting


def test_a_difference_is_named():
    assert first_difference(["a=1 b=2"], ["a=1 b=2"]) is None
    assert first_difference(["a=1 b=2", "a=1 b=3"], ["a=1 b=2", "a=1 b=4"]) == "push 1: b=3 | b=4"
    assert first_difference(["a=1"], ["a=1", "a=2"]) == "1 and 2 lines"
