"""States of the MuJoCo world: to the bit, in contact, in another world, in another process; branches."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from deformpush.cell.world import WorldError
from deformpush.checks import mujoco as gates
from deformpush.checks.by_world import build_bench
from deformpush.worlds.tool_motion import Line, ramp
from tests.setups import begun, setup

BENCH = build_bench(["world=mujoco"])
ARM = setup("robot=kuka_iiwa").robot
LINE = Line(BENCH.path(0.03, 0.02), 0.006)
PROFILE = ramp(LINE.length, 0.15, 1.5, BENCH.spec.engine.step)
HALF = 2 * len(PROFILE) // 3


@pytest.fixture
def world():
    world = BENCH.world()
    yield world
    world.close()


def taken_up(world, state: bytes) -> np.ndarray:
    """The nodes after the second part of a push whose first part led to this state."""
    world.restore(state)
    gates.carry(world, LINE, PROFILE[HALF:])
    return world.nodes()


def test_in_mid_contact_the_same_data_fresh_data_and_a_rebuilt_world_go_on_alike(world):
    gates.carry(world, LINE, PROFILE[:HALF])
    assert world.simulation.tool_force() > 0.5
    state = world.save()
    gates.carry(world, LINE, PROFILE[HALF:])
    straight_on = world.nodes()
    np.testing.assert_array_equal(taken_up(world, state), straight_on)
    np.testing.assert_array_equal(taken_up(BENCH.world(), state), straight_on)
    assert world.save() != state


def test_a_state_outlives_its_process(tmp_path, world):
    gates.carry(world, LINE, PROFILE[:HALF])
    (tmp_path / "state").write_bytes(world.save())
    here = hashlib.sha256(taken_up(world, world.save()).tobytes()).hexdigest()
    code = f"""
import hashlib
from tests.worlds.test_mujoco_states import BENCH, taken_up
nodes = taken_up(BENCH.world(), open({str(tmp_path / "state")!r}, "rb").read())
print(hashlib.sha256(nodes.tobytes()).hexdigest())
"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    )
    assert done.stdout.strip() == here


def test_saving_and_returning_change_nothing(world):
    other = BENCH.world()
    for one in (world, other):
        one.push(BENCH.path(0.02))
        if one is world:
            one.restore(one.save())
            one.save()
        one.push(BENCH.path(0.03, 0.02))
    np.testing.assert_array_equal(world.nodes(), other.nodes())
    assert world.save() == other.save()


def test_pushes_after_a_state_measure_alike(world):
    state = world.save()
    outcomes = []
    for _ in range(2):
        world.restore(state)
        outcomes.append(world.push(BENCH.path(0.03, 0.02)))
    for name in ("steps", "tip_error", "tool_force_peak", "tool_force_mean", "strain"):
        first, second = (getattr(outcome, name) for outcome in outcomes)
        assert first == second, name


def test_the_arms_posture_is_part_of_the_state():
    world = replace(BENCH, tool=ARM).world()
    world.tool.prepare(LINE.at(np.linspace(-0.016, LINE.length, 25)))
    gates.carry(world, LINE, PROFILE[:HALF])
    joints, state = world.joints(), world.save()
    other = replace(BENCH, tool=ARM).world()
    assert other.joints() != joints
    other.restore(state)
    assert other.joints() == joints
    np.testing.assert_array_equal(other.tool.tip(), world.tool.tip())


def test_a_world_that_exploded_returns_to_a_state(world):
    state = world.save()
    end = world.push(BENCH.path(0.02)).strain
    world.restore(state)
    world.simulation.data.qvel[30] = np.nan
    with pytest.raises(WorldError):
        world.push(BENCH.path(0.02))
    world.restore(state)
    assert world.push(BENCH.path(0.02)).strain == end


def damaged(state: bytes, at: int) -> bytes:
    return state[:at] + bytes([state[at] ^ 1]) + state[at + 1 :]


def inverted(state: bytes) -> bytes:
    """One node far away: qpos follows the head and the time."""
    at = len(state) - 8 * 1194
    return state[:at] + np.float64(1e3).tobytes() + state[at + 8 :]


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (lambda world: b"", "no state of world=mujoco"),
        (lambda world: b"\x00" * 20000, "no state of world=mujoco"),
        (lambda world: damaged(world.save(), 40), "a state of another world"),
        (lambda world: world.save()[:-8], "a damaged state"),
        (lambda world: world.save() + b"\x00", "a damaged state"),
        (lambda world: world.save()[:-8] + np.float64(np.nan).tobytes(), "a damaged state: not all"),
        (lambda world: world.save()[:-8] + np.float64(-np.inf).tobytes(), "a damaged state: not all"),
        (lambda world: inverted(world.save()), "a damaged state: the simulation exploded: volume ratios"),
        (lambda world: replace(BENCH, tool=ARM).world().save(), "a state of another world"),
        (lambda world: other_world("object=meat"), "a state of another world"),
        (lambda world: other_world("world.engine.masses=volume"), "a state of another world"),
        (lambda world: other_world("object.material.friction=0.4"), "a state of another world"),
        (lambda world: other_world("object.start=[0.5,0.0]"), "a state of another world"),
        (lambda world: other_world("robot.friction=0.3"), "a state of another world"),
    ],
)
def test_what_is_no_state_of_this_world_is_refused_and_nothing_changes(state, message, world):
    world.push(BENCH.path(0.02))
    before = world.save()
    with pytest.raises(ValueError, match=f"^{message}"):
        world.restore(state(world))
    assert world.save() == before


def test_a_state_of_an_arm_with_other_settings_is_refused():
    arms = (ARM, replace(ARM, park=(0.5, *ARM.park[1:])))
    mine, other = (replace(BENCH, tool=arm).world() for arm in arms)
    with pytest.raises(ValueError, match=r"^a state of another world"):
        mine.restore(other.save())


def other_world(*overrides: str) -> bytes:
    return build_bench(["world=mujoco", *overrides]).world().save()


@pytest.mark.parametrize("robot", ["tool", "kuka_iiwa"])
def test_branches_foretell_a_push_and_leave_the_world_alone(robot):
    episode = begun(setup("world=mujoco", f"robot={robot}", "optimizer=random"))
    world = episode.cell.world
    U = np.array([[0.5, 0.03], [0.25, 0.02], [0.7, 0.02]])
    before = world.save()
    foretold = episode.e_T_after(U)
    assert world.save() == before
    assert np.isfinite(foretold).all()
    after = episode.push(u=U[1])
    assert after.errors.e_T == foretold[1] != foretold[0]


def test_a_branch_that_fails_leaves_a_gap(world, monkeypatch):
    far = replace(BENCH.path(0.02), start=np.array([9.0, 9.0]))
    with_arm = replace(BENCH, tool=ARM).world()
    first, gap, last = with_arm.pictures_after([BENCH.path(0.01), far, BENCH.path(0.02)])
    assert gap is None
    assert (first != last).any()


def test_the_same_push_in_two_processes_ends_with_the_same_bits():
    command = [sys.executable, "-m", "deformpush", "doctor", "--digest", "world=mujoco"]
    found = {subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2)}
    (digest,) = found
    assert len(digest.strip()) == 64
