"""The loop on the toy world: consistent records, and every way a run can end."""

import json

import numpy as np
import pytest

from deformpush import loop
from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import WorldError
from deformpush.errors import UserError
from deformpush.experiment.assemble import begin, build_cell, build_optimizer
from deformpush.experiment.run import make_run
from deformpush.optimizer.rivals.random_push import RandomPush
from deformpush.push_record import EFFECTIVE_POINTS
from deformpush.record.poses import read_poses
from deformpush.record.saved_config import read_config
from deformpush.record.table import read
from deformpush.task import ERROR_COLUMNS
from deformpush.worlds.toy import ToyWorld
from tests.setups import begun, setup

TOY = ["world=toy", "robot=tool", "record=off"]
CAREFUL = setup(*TOY, "optimizer=greedy", "seed=1")
AIMLESS = setup(*TOY, "optimizer=random", "max_pushes=6")
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
    w = read_config(folder / "config.yaml")["task"]["weights"]
    e_T = w["k_c"] * table.e_c + w["k_theta"] * table.e_theta.abs() + w["k_gamma"] * table.e_gamma
    np.testing.assert_allclose(table.e_T, e_T, atol=1e-12)
    assert np.isnan(table.xi[0])
    assert np.isnan(table.kappa[0])
    for name in ERROR_COLUMNS:
        assert end[name] == table[name].iloc[-1]
    assert table.steps.sum() == end["steps"]
    assert table.e_c[0] == pytest.approx(1.0)
    trace = read_poses(folder / "contours.npz")
    assert len(trace.contours) == len(table)
    np.testing.assert_allclose(
        np.linalg.norm(trace.centroids - trace.goal_c, axis=1), table.position_error_m, atol=1e-9
    )
    return table


def test_a_run_that_reaches_the_goal(tmp_path, capsys):
    assert make_run(CAREFUL, tmp_path).status == "reached"
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
    made = setup(*TOY, "max_pushes=13", "task.goal.offset=[0.0,0.3]")
    assert make_run(made, tmp_path).status == "budget"
    table = is_consistent(tmp_path)
    assert table.phase[1:11].tolist() == ["initial"] * 10
    assert set(table.phase[11:]) <= {"exploit", "explore"}
    pushes = table[1:]
    assert pushes.d.between(pushes.d_min - 1e-12, pushes.d_max + 1e-12).all()
    assert pushes.kappa.between(0, 1).all()
    assert np.isfinite(pushes.xi_mean[10:]).all()
    assert (pushes.xi_std[10:] > 0).all()


def test_a_run_that_spends_its_budget(tmp_path):
    assert make_run(AIMLESS, tmp_path).status == "budget"
    assert len(is_consistent(tmp_path)) == 7
    assert summary(tmp_path)["status"] == "budget"
    assert summary(tmp_path)["reason"] == "the budget of 6 pushes is spent"


def test_the_same_seed_makes_the_same_run(tmp_path):
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        make_run(setup(*TOY, "optimizer=random", "max_pushes=4", f"seed={seed}"), tmp_path / name)
    a, b, c = (read(tmp_path / name / "pushes.csv").drop(columns=TIMES) for name in "abc")
    assert a.equals(b)
    assert not a.equals(c)


def test_a_goal_reached_at_the_start_takes_no_push(tmp_path):
    made = setup(*TOY, "optimizer=greedy", "task.goal.offset=[0.0,0.015]")
    assert make_run(made, tmp_path).status == "reached"
    assert summary(tmp_path)["status"] == "reached"
    assert summary(tmp_path)["pushes"] == 0
    assert len(read(tmp_path / "pushes.csv")) == 1


@pytest.mark.parametrize(
    ("method", "call", "error"),
    [
        ("push", 4, WorldError("the simulation exploded: too fast")),
        # The first picture is that of the start.
        ("picture", 5, PerceptionError("the object left the picture")),
    ],
)
def test_a_breakdown_ends_the_run_as_failed_and_keeps_what_was(
    method, call, error, tmp_path, monkeypatch, capsys
):
    breaks_at(monkeypatch, call, method, error)
    assert make_run(AIMLESS, tmp_path).status == "failed"
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
        make_run(AIMLESS, tmp_path)
    assert summary(tmp_path)["status"] == status
    assert len(is_consistent(tmp_path)) == 3


def test_whatever_is_recorded_the_run_is_the_same(tmp_path):
    """Maps make the optimizer show what it believes during the design too."""
    settings = ["world=toy", "robot=tool", "max_pushes=13", "stop=strict", "task.goal.offset=[0,0.3]"]
    for name in ("off", "light"):
        make_run(setup(*settings, f"record={name}", "record.figures=false"), tmp_path / name)
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
            r"^object.effective: gives an effective contour of zero length",
        ),
    ],
)
def test_an_impossible_task_is_refused_before_anything_is_written(override, message, tmp_path):
    with pytest.raises(UserError, match=message):
        make_run(setup(*TOY, override), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_goal_out_of_the_robots_reach_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(ToyWorld, "can_reach", lambda self, points: points[:, 1] < 0.1)
    with pytest.raises(UserError, match=r"^task.goal.offset = \[0.0, 0.2\]: .* out of the robot's reach"):
        make_run(setup(*TOY), tmp_path / "run")
    assert not (tmp_path / "run").exists()


class Ears(RandomPush):
    """Keeps what the loop says to it."""

    def __init__(self, inner, needs=()):
        self.inner, self._needs = inner, frozenset(needs)
        self.asked, self.told, self.attached = [], [], None

    @property
    def needs(self):
        return self._needs

    def attach(self, branches):
        self.attached = branches

    def ask(self, state=None):
        self.asked.append(state)
        return self.inner.ask(state)

    def tell(self, u, xi, before=None, after=None):
        self.told.append((u, xi, before, after))

    def state(self):
        return {}


def listened(needs=()):
    """An episode of six pushes, its optimizer, and all records."""
    ears = Ears(build_optimizer(AIMLESS), needs)
    episode = begin(AIMLESS, build_cell(AIMLESS), ears)
    records = [episode.record]
    ending = loop.run(episode, False, [records.append])
    assert ending.status == "budget"
    return episode, ears, records


def test_the_optimizer_is_told_what_was_pushed_and_what_it_brought():
    """What it hears is the difference of the total error that the listeners see."""
    episode, ears, records = listened()
    assert [r.k for r in records] == list(range(7))
    for (u, xi, state, then), before, after in zip(ears.told, records[:-1], records[1:], strict=True):
        action = after.action
        assert xi == after.errors.e_T - before.errors.e_T == action.xi
        assert u.tolist() == action.u.tolist()
        np.testing.assert_array_equal(state.seen.c, before.view.seen.c)
        np.testing.assert_array_equal(then.seen.c, after.view.seen.c)
        shape = state.errors["e_gamma"]
        e_T = state.total_error(*state.seen.c, state.seen.theta, shape)
        assert e_T == pytest.approx(before.errors.e_T, abs=1e-12)
        assert state.e_T_share == pytest.approx(before.errors.e_T / records[0].errors.e_T)
        np.testing.assert_array_equal(state.effective.places(EFFECTIVE_POINTS), action.effective)
        assert np.linalg.norm(action.path.end - action.path.start) > u[1]
        (path,) = state.paths(u[None])
        np.testing.assert_array_equal(path.rounded().end, action.path.end)
        assert (state.target, then.target) == (episode.target, episode.target)
    assert len(ears.told) == len(ears.asked) == 6
    for (*_, state, _), asked in zip(ears.told, ears.asked, strict=True):
        assert state is asked
    way = sum(np.linalg.norm(r.action.path.end - r.action.path.start) for r in records[1:])
    assert records[-1].timing.sim_time_s == pytest.approx(way)


def test_the_optimizer_is_given_the_branches_before_it_is_asked():
    episode, ears, _ = listened()
    assert ears.attached is episode


def test_the_film_of_a_push_is_made_out_only_for_those_who_need_it():
    *_, ears, _ = listened()
    assert all((state.pressed, state.at_rest) == ((), None) for state in ears.asked)
    *_, ears, records = listened({"film"})
    assert ears.asked[0].pressed == ()
    for state, record in zip(ears.asked[1:], records[1:], strict=False):
        assert len(state.pressed) == len(record.action.outcome.film) > 3
        apart = np.linalg.norm(state.at_rest.mean(axis=0) - record.view.seen.c)
        assert apart < 1e-3, "the contour at rest is that of the object now"


def test_a_second_look_does_not_change_what_was_chosen_but_a_push_does():
    episode = begun(AIMLESS)
    first, second = episode.push(), episode.push()
    assert (first.k, second.k) == (1, 2)
    assert second.action.u.tolist() != first.action.u.tolist()
    assert episode.record is second


def test_a_push_that_is_given_is_made_whatever_the_optimizer_wants():
    """A run that is taken up again gives the pushes it made; the optimizer hears of these."""
    episode = begun(AIMLESS)
    u = np.array([0.5, 0.02])
    record = episode.push(u=u, speed=0.05)
    assert record.action.u is u
    assert record.action.path.speed == 0.05
    assert episode.wanted.tolist() != u.tolist()
    assert record.action.proposal.u.tolist() == episode.wanted.tolist()
