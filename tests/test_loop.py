"""The loop on the toy world: consistent records, and every way a run can end."""

import json
from dataclasses import replace

import numpy as np
import pytest

from deformpush import loop as runner
from deformpush.cell.cell import nearest_reachable
from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import WorldError
from deformpush.config.build import load
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.run import execute
from deformpush.record.poses import read_trace
from deformpush.record.table import read
from deformpush.worlds.toy import ToyWorld

TOY = ["world=toy", "robot=tool", "record=off"]
CAREFUL = compose([*TOY, "optimizer=greedy", "seed=1"])
AIMLESS = compose([*TOY, "optimizer=random", "max_pushes=6"])
TIMES = ["step_s", "render_s", "decide_s", "record_s"]


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def breaks_at(monkeypatch, k, name, error):
    """Let the k-th call of a method of the toy world raise."""
    whole, calls = getattr(ToyWorld, name), []

    def method(self, *args):
        calls.append(1)
        if len(calls) == k:
            raise error
        return whole(self, *args)

    monkeypatch.setattr(ToyWorld, name, method)


def is_consistent(folder):
    """Table, contours and summary tell the same story; returns the table."""
    table, end = read(folder / "pushes.csv"), summary(folder)
    assert table.k.tolist() == list(range(len(table)))
    assert end["pushes"] == len(table) - 1
    np.testing.assert_allclose(table.xi[1:], np.diff(table.e_T), atol=1e-12)
    w = load(folder / "config.yaml").task.weights
    e_T = w.k_c * table.e_c + w.k_theta * table.e_theta.abs() + w.k_gamma * table.e_gamma
    np.testing.assert_allclose(table.e_T, e_T, atol=1e-12)
    assert np.isnan(table.xi[0])
    assert np.isnan(table.kappa[0])
    for name in ("e_c", "e_theta", "e_gamma", "e_T", "position_error_m", "angle_error_rad"):
        assert end[name] == table[name].iloc[-1]
    assert table.steps.sum() == end["steps"]
    assert table.e_c[0] == pytest.approx(1.0)
    trace = read_trace(folder / "contours.npz")
    assert len(trace.contours) == len(table)
    np.testing.assert_allclose(
        np.linalg.norm(trace.centroids - trace.goal_c, axis=1), table.position_error_m, atol=1e-9
    )
    return table


def test_a_run_that_reaches_the_goal(tmp_path, capsys):
    assert execute(CAREFUL, tmp_path) == 0
    table, end = is_consistent(tmp_path), summary(tmp_path)
    assert end["status"] == "reached"
    last = table.iloc[-1]
    assert last.position_error_m <= 0.02
    assert abs(last.angle_error_rad) <= np.radians(7)
    assert last.e_gamma <= 0.15
    before = table.iloc[:-1]
    within = (before.position_error_m <= 0.02) & (before.angle_error_rad.abs() <= np.radians(7))
    assert not (within & (before.e_gamma <= 0.15)).any(), "it stops with the first push that meets the rule"
    assert capsys.readouterr().out.startswith(f"reached: reached the goal after {len(table) - 1} pushes\n")


def test_the_papers_optimizer_pushes_within_its_bounds(tmp_path):
    cfg = compose([*TOY, "max_pushes=13", "task.goal.offset=[0.0,0.3]"])
    assert execute(cfg, tmp_path) == 0
    table = is_consistent(tmp_path)
    assert table.phase[1:11].tolist() == ["initial"] * 10
    assert set(table.phase[11:]) <= {"exploit", "explore"}
    pushes = table[1:]
    assert pushes.d.between(pushes.d_min - 1e-12, pushes.d_max + 1e-12).all()
    assert pushes.kappa.between(0, 1).all()
    assert np.isfinite(pushes.xi_mean[10:]).all()
    assert (pushes.xi_std[10:] > 0).all()


def test_a_run_that_spends_its_budget(tmp_path):
    assert execute(AIMLESS, tmp_path) == 0
    assert len(is_consistent(tmp_path)) == 7
    assert summary(tmp_path)["status"] == "budget"
    assert summary(tmp_path)["reason"] == "the budget of 6 pushes is spent"


def test_the_same_seed_makes_the_same_run(tmp_path):
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        execute(compose([*TOY, "optimizer=random", "max_pushes=4", f"seed={seed}"]), tmp_path / name)
    a, b, c = (read(tmp_path / name / "pushes.csv").drop(columns=TIMES) for name in "abc")
    assert a.equals(b)
    assert not a.equals(c)


def test_a_goal_reached_at_the_start_takes_no_push(tmp_path):
    cfg = compose([*TOY, "optimizer=greedy", "task.goal.offset=[0.0,0.015]"])
    assert execute(cfg, tmp_path) == 0
    assert summary(tmp_path)["status"] == "reached"
    assert summary(tmp_path)["pushes"] == 0
    assert len(read(tmp_path / "pushes.csv")) == 1


@pytest.mark.parametrize(
    ("method", "call", "error"),
    [
        ("push", 4, WorldError("the simulation exploded: too fast")),
        (
            "image",
            5,
            PerceptionError("the object left the picture"),
        ),  # the first picture is that of the start
    ],
)
def test_a_breakdown_ends_the_run_as_failed_and_keeps_what_was(
    method, call, error, tmp_path, monkeypatch, capsys
):
    breaks_at(monkeypatch, call, method, error)
    assert execute(AIMLESS, tmp_path) == 1
    end = summary(tmp_path)
    assert (end["status"], end["reason"], end["pushes"]) == ("failed", str(error), 3)
    assert len(is_consistent(tmp_path)) == 4
    assert f"failed: failed after 3 pushes ({error})" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("error", "status"),
    [(KeyboardInterrupt(), "interrupted"), (ZeroDivisionError("a bug"), "failed")],
    ids=["Ctrl-C", "bug"],
)
def test_an_interruption_or_a_bug_is_kept_and_raised(error, status, tmp_path, monkeypatch):
    breaks_at(monkeypatch, 3, "push", error)
    with pytest.raises(type(error)):
        execute(AIMLESS, tmp_path)
    assert summary(tmp_path)["status"] == status
    assert len(is_consistent(tmp_path)) == 3


def test_whatever_is_recorded_the_run_is_the_same(tmp_path):
    """Maps make the optimizer show what it believes during the design too."""
    settings = ["world=toy", "robot=tool", "max_pushes=13", "stop=strict", "task.goal.offset=[0,0.3]"]
    for name in ("off", "light"):
        execute(compose([*settings, f"record={name}", "record.figures=false"]), tmp_path / name)
    off, light = (read(tmp_path / name / "pushes.csv").drop(columns=TIMES) for name in ("off", "light"))
    assert off.equals(light)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (
            "task.goal.offset=[0.0,0.5]",
            r"^task.goal.offset = \[0.0, 0.5\]: the goal at \(0.580, 0.400\) m is not wholly",
        ),
        (
            "task.goal.offset=[0.0,0.0]",
            r"^task.goal.offset = \[0.0, 0.0\]: puts the goal within 1 mm of the start",
        ),
        ("object.start=[5,5]", r"^object.start: no object in the picture"),
        ("object.start=[0.25,0]", r"^object.start: the object left the picture"),
        (
            "object.effective.last_deg=90.5",
            r"^object.effective.last_deg = 90.5: gives an effective contour of zero length",
        ),
    ],
)
def test_an_impossible_task_is_refused_before_anything_is_written(override, message, tmp_path):
    with pytest.raises(UserError, match=message):
        execute(compose([*TOY, override]), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_goal_out_of_the_robots_reach_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(ToyWorld, "can_reach", lambda self, points: points[:, 1] < 0.1)
    with pytest.raises(UserError, match=r"^task.goal.offset = \[0.0, 0.2\]: .* out of the robot's reach"):
        execute(compose(TOY), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_push_out_of_reach_becomes_the_nearest_one_within(monkeypatch):
    cell = build_cell(AIMLESS)
    seen = runner.start(cell).seen
    wanted = np.array([0.02, 0.02])  # on the far side, from above
    u, path = nearest_reachable(cell, wanted, seen)
    np.testing.assert_array_equal(u, wanted)
    low = seen.c[1]
    monkeypatch.setattr(ToyWorld, "can_reach", lambda self, points: points[:, 1] < low)
    u, path = nearest_reachable(cell, wanted, seen)
    assert u[1] == 0.02
    assert max(path.start[1], path.end[1]) < low
    moved = abs(u[0] - wanted[0])
    for nearer in np.arange(0, min(moved, 1 - moved) - 0.005, 0.01):
        for kappa in ((wanted[0] + nearer) % 1, (wanted[0] - nearer) % 1):
            blocked = cell.push.plan(np.array([kappa, 0.02]), seen, cell.part)
            assert max(blocked.start[1], blocked.end[1]) >= low
    np.testing.assert_array_equal(path.start, cell.push.plan(u, seen, cell.part).start)


def test_an_object_no_push_can_reach_ends_the_run(monkeypatch):
    cell = build_cell(AIMLESS)
    seen = runner.start(cell).seen
    monkeypatch.setattr(ToyWorld, "can_reach", lambda self, points: np.zeros(len(points), bool))
    with pytest.raises(WorldError, match="can reach no push of 20 mm"):
        nearest_reachable(cell, np.array([0.5, 0.02]), seen)


def test_the_optimizer_is_told_what_was_pushed_and_what_it_brought():
    """What it hears is the difference of the total error that the watcher sees."""
    cell = build_cell(AIMLESS)
    told, asked, seen = [], [], []

    class Ears:
        S0 = 0

        def ask(self, state):
            asked.append(state)
            return cell.optimizer.ask(state)

        def tell(self, u, xi, before, after):
            told.append((u, xi, before, after))

        def state(self):
            return {}

    begin = runner.start(cell)
    episode = runner.Episode(replace(cell, optimizer=Ears()), begin)
    seen.append(episode.first)
    runner.run(episode, Silent(), lambda: None, seen.append)
    assert [r.k for r in seen] == list(range(7))
    for (u, xi, state, then), before, after in zip(told, seen[:-1], seen[1:], strict=True):
        assert xi == after.e_T - before.e_T == after.xi
        assert u.tolist() == [after.decision.kappa, after.decision.d]
        np.testing.assert_array_equal(state.c, before.after.c)
        np.testing.assert_array_equal(then.c, after.after.c)
        assert state.total_error(*state.c, state.theta, state.e_gamma) == pytest.approx(before.e_T, abs=1e-12)
        assert state.e_T_share == pytest.approx(before.e_T / seen[0].e_T)
        np.testing.assert_array_equal(state.effective, after.decision.effective)
        assert np.linalg.norm(after.decision.end - after.decision.start) > u[1]
    assert len(told) == len(asked) == 6
    assert seen[-1].sim_time_s == pytest.approx(
        sum(np.linalg.norm(r.decision.end - r.decision.start) for r in seen[1:])
    )


class Silent:
    """A recorder that writes nothing."""

    maps = False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def open(self, info, row0):
        return 0.0

    def push(self, record, knows):
        return 0.0

    def close(self, status, reason):
        return status, reason
