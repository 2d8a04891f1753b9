"""A preset of Python and the option of the command line are the same optimizer, push for push."""

import ast
import inspect
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from deformpush import UserError, presets
from deformpush.config.groups import conf_dir
from deformpush.experiment.api import compose
from deformpush.experiment.assemble import begin, build_cell, build_optimizer
from deformpush.experiment.seeding import generator
from deformpush.experiment.setup import Setup
from deformpush.optimizer.base import Branches, Optimizer
from deformpush.state import Proposal, State

OPTIONS = sorted(file.stem for file in (conf_dir() / "optimizer").glob("*.yaml"))
RIVALS = ("botorch", "botorch_default", "cmaes", "optuna_gp")
"""Need the extra `rivals`."""
QUICK = {"oracle": ("optimizer.kappas=4", "optimizer.refined=2")}
"""Settings without which it takes too long."""


@dataclass
class Twins:
    """Asks and tells two optimizers the same and holds their answers against each other."""

    one: Optimizer
    other: Optimizer
    asked: int = 0

    def __post_init__(self) -> None:
        self.uses, self.S0, self.needs = self.one.uses, self.one.S0, self.one.needs

    def attach(self, branches: Branches) -> None:
        self.one.attach(branches)
        self.other.attach(branches)

    def ask(self, state: State | None = None) -> Proposal:
        mine, yours = self.one.ask(state), self.other.ask(state)
        self.asked += 1
        assert np.array_equal(mine.u, yours.u), f"push {self.asked}"
        assert np.array_equal(mine.bounds, yours.bounds)
        assert mine.phase == yours.phase
        assert np.array_equal(
            [mine.acq, mine.mean, mine.std], [yours.acq, yours.mean, yours.std], equal_nan=True
        )
        assert mine.speed == yours.speed
        return mine

    def tell(self, u: np.ndarray, xi: float, before: State | None = None, after: State | None = None) -> None:
        self.one.tell(u, xi, before, after)
        self.other.tell(u, xi, before, after)

    def predict(self, U: np.ndarray, state: State | None = None) -> None:
        """Of no use here."""

    def maps(self, n: int = 32) -> dict[str, np.ndarray]:
        return {}

    def state(self) -> dict[str, Any]:
        return self.one.state()

    def restore(self, state: Mapping[str, Any]) -> None:
        self.one.restore(state)


def preset_of(name: str, setup: Setup, *settings: str, **more: float) -> Optimizer:
    """The preset, with the random numbers and the contour that a run of the command line has."""
    return getattr(presets, name)(
        *settings,
        d=setup.object.d,
        rng=generator(setup.seed, "optimizer"),
        closed=setup.object.effective.closed,
        **more,
    )


def drive(setup: Setup, preset: Optimizer, pushes: int) -> Twins:
    """Push in a toy world as long as both agree."""
    twins = Twins(build_optimizer(setup), preset)
    cell = build_cell(setup)
    with closing(cell.world):
        episode = begin(setup, cell, twins)
        for _ in range(pushes):
            episode.push()
    assert twins.asked == pushes
    return twins


@pytest.mark.parametrize("name", OPTIONS)
def test_a_preset_pushes_as_the_command_line_does(name):
    if name in RIVALS:
        pytest.importorskip("botorch", reason="extra `rivals` is not installed")
    quick = QUICK.get(name, ())
    setup = compose("world=toy", "robot=tool", "record=off", f"optimizer={name}", *quick, seed=2)
    preset = preset_of(name, setup, *quick)
    drive(setup, preset, pushes=preset.S0 + 3)


def test_safe_pushes_as_the_command_line_does():
    limits = ("optimizer=abo_motion", "acquisition=safe_lcb", "object.strain_limit=0.08")
    toy = ("world=toy", "robot=tool", "record=off", "acq.signal=contour")
    setup = compose(*toy, *limits)
    drive(setup, preset_of("safe", setup, "acq.signal=contour", limit=0.08), pushes=4)


def test_there_is_a_function_for_every_option():
    functions = {
        name
        for name, value in vars(presets).items()
        if inspect.isfunction(value) and value.__module__ == presets.__name__ and not name.startswith("_")
    }
    assert functions == {*OPTIONS, "safe"}
    assert all(getattr(presets, name).__doc__ for name in functions)


def test_numbers_stand_in_the_configuration_alone():
    nodes = ast.walk(ast.parse(inspect.getsource(presets)))
    numbers = [
        node.value for node in nodes if isinstance(node, ast.Constant) and type(node.value) in (int, float)
    ]
    assert numbers == []


def test_limits_and_settings_are_those_given():
    optimizer = presets.abo("optimizer.S0=3", d=(0.02, 0.025), kappa=(0.2, 0.4), rng=np.random.default_rng(0))
    assert optimizer.S0 == 3
    asked = []
    for _ in range(5):
        asked.append(optimizer.ask().u)
        optimizer.tell(asked[-1], -0.01)
    lowest, highest = np.min(asked, axis=0), np.max(asked, axis=0)
    assert 0.2 <= lowest[0] < highest[0] <= 0.4
    assert 0.02 <= lowest[1] < highest[1] <= 0.025


def test_random_numbers_come_from_the_generator_given():
    def first(seed: int) -> np.ndarray:
        return presets.random(d=(0.01, 0.03), rng=np.random.default_rng(seed)).ask().u

    assert np.array_equal(first(1), first(1))
    assert not np.array_equal(first(1), first(2))


@pytest.mark.parametrize(
    ("settings", "begins"), [(("acq.w=-1",), "acq.w = -1: must be"), (("kernel=rbg",), "kernel=rbg: no such")]
)
def test_a_wrong_setting_is_refused_in_one_line(settings, begins):
    with pytest.raises(UserError) as caught:
        presets.abo(*settings, d=(0.01, 0.03), rng=np.random.default_rng(0))
    assert caught.value.line.startswith(begins)


def test_a_wrong_range_is_refused_in_one_line():
    with pytest.raises(UserError, match=r"bounds\.d"):
        presets.abo(d=(0.03, 0.01), rng=np.random.default_rng(0))
