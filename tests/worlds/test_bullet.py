"""What only the Bullet world has: a limit of its time step, C++ that talks, a library that may be missing."""

import os
import subprocess
import sys

import pytest

from deformpush.cell.world import WorldError
from deformpush.checks.by_world import build_bench
from deformpush.errors import UserError
from deformpush.experiment.assemble import build_cell
from deformpush.worlds.bullet.engine import Engine
from tests.setups import setup


def test_a_time_step_beyond_stability_is_refused():
    with pytest.raises(
        ValueError, match=r"^dt: 0.021 s is unstable; it must not exceed twice damping = 0.02 s"
    ):
        Engine(dt=0.021, damping=0.01, gravity=9.81)


def test_the_engine_says_nothing_on_the_terminal():
    """Nor does its import, which only a fresh process shows."""
    code = "from deformpush.worlds.bullet.engine import connect; connect().disconnect(); print('said')"
    # Where Python does not buffer, C does not either, and nothing could be left over in its buffer.
    buffered = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=buffered)
    assert (done.stdout, done.stderr) == ("said\n", "")


def test_without_pybullet_the_other_engine_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pybullet", None)
    with pytest.raises(
        UserError, match=r"^world=bullet: PyBullet is not installed; .*world=mujoco on others"
    ):
        build_cell(setup("world=bullet", "robot=tool"))


def test_an_explosion_of_the_engine_ends_the_push():
    bench = build_bench([])
    world = bench.world()
    world.client.setTimeStep(0.05)
    with pytest.raises(WorldError, match=r"the simulation exploded: .*world\.engine\.dt"):
        world.push(bench.path(0.03))
    world.close()
