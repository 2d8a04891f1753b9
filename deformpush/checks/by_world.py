"""The gates of each world: the contract for all, physics and accuracy for those that are listed here."""

from collections.abc import Iterator, Sequence
from importlib import import_module

from deformpush.cell.robot import BareTool
from deformpush.checks.bench import Bench
from deformpush.checks.contract import contract
from deformpush.checks.gate import Gate
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.setup import read

BENCHES = {
    "bullet": "deformpush.checks.bullet.BulletBench",
    "mujoco": "deformpush.checks.mujoco.MujocoBench",
}
"""What examines the physics of an option of the group `world`; an engine is imported when it is asked for."""


def gates(overrides: Sequence[str]) -> Iterator[Gate]:
    """All gates of the world that these settings describe, one after the other.

    Raises:
        UserError: names the setting that is wrong.
    """
    world = compose(overrides).options.world
    bench = build_bench(overrides) if world in BENCHES else None
    yield from contract(overrides)
    if bench is not None:
        yield from bench.gates()


def build_bench(overrides: Sequence[str]) -> Bench:
    """What the physics gates examine.

    Raises:
        UserError: names the setting that is wrong, or says that this world has no such gates.
    """
    setup = read(compose(["robot=tool", *overrides]))
    world, robot = setup.options["world"], setup.robot
    if world not in BENCHES or not isinstance(robot, BareTool):
        raise UserError(
            f"world={world}, robot={setup.options['robot']}: the physics gates need "
            f"{' or '.join(f'world={name}' for name in BENCHES)} with robot=tool"
        )
    module, _, name = BENCHES[world].rpartition(".")
    kind: type[Bench] = getattr(import_module(module), name)
    return kind(setup.world, setup.object, robot, setup.camera, setup.push.tool_radius, tuple(overrides))
