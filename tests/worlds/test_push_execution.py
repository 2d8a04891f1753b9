"""The order of a push, its guard and its measures, with an engine that obeys the test."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.cell.push import ToolPath
from deformpush.cell.world import Outcome, WorldError
from deformpush.mechanics.mesh import slab
from deformpush.worlds.explosion import ExplosionGuard
from deformpush.worlds.push_execution import PushExecution, sum_up
from deformpush.worlds.tool_motion import Motion
from tests import pictures

MESH = slab(pictures.RECT, 0.02, 0.05)
MOTION = Motion(
    speed=0.15, acceleration=1.5, lead=0.006, clear=0.004, settle_speed=0.002, settle_s=0.5, frames=6
)
RADIUS = 0.01
PATH = ToolPath(np.array([0.0, -0.07]), np.array([0.0, 1.0]), 0.01, 0.03)


class Obedient:
    """A drive and its engine: the object is a rigid slab that yields to the tool."""

    urdf, check_every = None, 8
    dt = 0.005

    def __init__(self) -> None:
        self.away, self.log, self.at, self.moved = np.array([0.0, 9.0]), [], np.array([0.0, 9.0]), 0.0
        self.velocity, self.sticks = np.zeros(2), False

    def step(self) -> None:
        self.log.append("step")
        self.at = self.at + self.dt * self.velocity
        reached = self.at[1] + RADIUS + 0.05
        if self.at[1] < 1 and (reached > self.moved or self.sticks):
            self.moved = reached

    def nodes(self) -> np.ndarray:
        return MESH.nodes + np.array([0.0, self.moved, 0.0])

    def tool_force(self) -> float:
        return 2.0 if self.at[1] + RADIUS + 0.05 >= self.moved > 0 else 0.0

    def can_reach(self, points: np.ndarray) -> np.ndarray:
        return np.ones(len(points), bool)

    def prepare(self, points: np.ndarray) -> None:
        self.log.append("prepare")
        self.planned = points

    def place(self, xy: np.ndarray) -> None:
        self.log.append("place")
        self.follow(xy, np.zeros(2))

    def follow(self, xy: np.ndarray, velocity: np.ndarray) -> None:
        self.at, self.velocity = xy, velocity

    def tip(self) -> np.ndarray:
        return np.append(self.at, 0.001)

    def park(self) -> None:
        self.log.append("park")
        self.follow(self.away, np.zeros(2))

    def joints(self) -> dict[str, float]:
        return {"turn": float(self.at[1])}

    def close(self) -> None:
        self.log.append("close")


@pytest.fixture
def engine():
    return Obedient()


def execution(engine: Obedient) -> PushExecution:
    return PushExecution(engine, engine, MESH, MOTION, RADIUS)


def push(engine: Obedient, path: ToolPath = PATH) -> Outcome:
    return execution(engine).push(path, 50.0, None)


def test_the_tool_is_planned_placed_carried_parked_and_the_object_rests(engine):
    outcome = push(engine)
    *before, last = [name for name in engine.log if name != "step"]
    assert (before, last) == (["prepare", "place"], "park")
    assert outcome.steps == engine.log.count("step")
    rest = engine.log[engine.log.index("park") :].count("step")
    assert rest == 8, "one look tells that a rigid body rests"
    assert outcome.sim_s == pytest.approx(outcome.steps * engine.dt)
    assert engine.nodes()[:, 1].min() == pytest.approx(PATH.end[1] + RADIUS)
    assert outcome.tip_error < 1e-12


def test_the_way_back_is_planned_too_and_left_once_clear(engine):
    push(engine)
    along = engine.planned @ PATH.direction
    assert along.max() == pytest.approx(PATH.end[1])
    assert along.min() == pytest.approx(PATH.contact[1] - MOTION.lead - 4 * MOTION.clear)
    assert np.diff(along).max() < 0.0035


def test_an_object_that_sticks_to_the_tool_is_an_error(engine):
    engine.sticks = True
    with pytest.raises(WorldError, match="the object sticks to the tool"):
        push(engine)


def test_moments_are_kept_on_the_way_forth(engine):
    outcome = push(engine)
    assert len(outcome.motion) == MOTION.frames
    assert outcome.motion[-1].tool[1] == pytest.approx(PATH.end[1])
    assert [moment.joints["turn"] for moment in outcome.motion] == [m.tool[1] for m in outcome.motion]
    assert all(moment.strain.shape == (len(MESH.nodes),) for moment in outcome.motion)


def test_the_film_has_the_pictures_that_the_camera_takes(engine):
    """50 a second of the way forth, 36 mm at 0.15 m/s with ramps of 0.1 s: 0.34 s."""
    assert len(push(engine).film) == pytest.approx(17, abs=1)
    assert len(execution(Obedient()).push(PATH, 25.0, None).film) == pytest.approx(9, abs=1)


def test_the_path_may_ask_for_another_speed(engine):
    slow = push(engine, replace(PATH, speed=0.05))
    assert slow.sim_s > push(Obedient()).sim_s + 0.4


def test_a_push_without_measures_is_the_same_push(engine):
    push(engine)
    other = Obedient()
    execution(other).push_unmeasured(PATH)
    assert other.log == engine.log
    np.testing.assert_array_equal(other.nodes(), engine.nodes())


def test_the_force_is_told_from_the_first_touch_on(engine):
    outcome = push(engine)
    assert (outcome.tool_force_peak, outcome.tool_force_mean) == (2.0, 2.0)
    engine = Obedient()
    engine.tool_force = lambda: None
    outcome = push(engine)
    assert (outcome.tool_force_peak, outcome.tool_force_mean) == (None, None)


def test_the_last_bit_of_a_force_does_not_count(engine):
    told = push(engine)
    engine = Obedient()
    engine.tool_force = lambda: 2.0 * (1 + 1e-15)
    other = push(engine)
    assert (other.tool_force_peak, other.tool_force_mean) == (told.tool_force_peak, told.tool_force_mean)


@pytest.mark.parametrize(
    ("forces", "window", "told"),
    [
        ([0, 0, 1, 3, 5, 3], 1, (5, 3)),
        ([0, 0, 1, 3, 5, 3], 2, (4, 3)),
        ([0, 2, 0, 4], 1, (4, 2)),  # it slips off and touches again
        ([0, 6], 5, (6, 6)),  # shorter than the window
        ([0, 0], 2, (0, 0)),
        ([], 2, (None, None)),
        ([None, None], 2, (None, None)),
    ],
)
def test_peak_and_mean_of_a_force(forces, window, told):
    assert sum_up(forces, window) == pytest.approx(told)


def test_the_guard_accepts_what_a_push_does():
    guard = ExplosionGuard(MESH)
    guard.check(MESH.nodes)
    guard.check(MESH.nodes * (1.2, 0.9, 1.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda n: np.where(np.arange(len(n))[:, None] == 7, np.nan, n), "a node of the mesh is not finite"),
        (lambda n: n * (1, 1, -1), "volume ratios of tetrahedra run from -"),
        (lambda n: n * (1, 1, 3.2), "volume ratios of tetrahedra run from 3.2 to 3.2"),
        (lambda n: n * (2.1, 0.5, 1.0), "volume ratios of tetrahedra run from 1"),
    ],
    ids=["nan", "inverted", "swollen", "stretched"],
)
def test_the_guard_notices_an_explosion(change, message, engine):
    with pytest.raises(WorldError, match=f"the simulation exploded: {message}"):
        ExplosionGuard(MESH).check(change(MESH.nodes))
    engine.nodes = lambda: change(MESH.nodes)
    with pytest.raises(WorldError, match=f"the simulation exploded: {message}"):
        push(engine)


@pytest.mark.parametrize("way", ["forth", "back", "at rest"])
def test_the_guard_looks_all_the_time(way, engine):
    def nodes() -> np.ndarray:
        here = "at rest" if not engine.velocity.any() else "forth" if engine.velocity[1] > 0 else "back"
        return whole() * (1.0 if here != way else np.nan)

    whole, engine.nodes = engine.nodes, nodes
    with pytest.raises(WorldError, match="the simulation exploded"):
        push(engine)
    assert ("park" in engine.log) == (way == "at rest")
