"""What moves the tool in MuJoCo: where the arm's tip is, whatever the last bit of its kinematics."""

from types import SimpleNamespace

import numpy as np

from deformpush.worlds.arm.iiwa import Iiwa
from deformpush.worlds.mujoco.drive import ArmDrive
from tests.setups import setup

START, VELOCITY = np.array([0.58, -0.2]), np.array([0.0, 0.15])


def moves(steps: int = 8) -> list[np.ndarray]:
    """Place and speed of the tool in each step of a way forth."""
    made: list[np.ndarray] = []
    simulation = SimpleNamespace(dt=0.005, move_tool=lambda xy, v: made.append(np.concatenate([xy, v])))
    drive = ArmDrive(setup("robot=kuka_iiwa").robot, simulation, 0.01)
    drive.prepare(START + np.linspace(0.0, 0.02, 10)[:, None] * (VELOCITY / 0.15))
    for step in range(steps):
        drive.follow(START + step * simulation.dt * VELOCITY, VELOCITY)
    return made


def test_the_last_bit_of_the_arms_tip_does_not_reach_the_engine(monkeypatch):
    whole, rng = Iiwa.tip, np.random.default_rng(0)

    def otherwise(self, posture):
        tip, along = whole(self, posture)
        return tip + 1e-16 * rng.integers(-2, 3, 3), along

    usual = moves()
    monkeypatch.setattr(Iiwa, "tip", otherwise)
    np.testing.assert_array_equal(moves(), usual)
