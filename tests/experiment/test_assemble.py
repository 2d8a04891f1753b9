"""From a composed configuration to the parts of a run."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deformpush.cell.variation import Draw, vary
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment import assemble
from deformpush.experiment.assemble import begin, build_cell, build_optimizer, describe, varied
from deformpush.experiment.run import make_run
from deformpush.experiment.seeding import generator
from deformpush.experiment.setup import read
from deformpush.optimizer.base import Components
from deformpush.record.saved_config import read_config
from deformpush.task import TERMS
from deformpush.worlds.toy import ToyWorld
from tests.setups import begun, setup

ROOT = Path(__file__).resolve().parents[2]
TOY = ["world=toy", "robot=tool"]
MADE = setup(*TOY)


def test_the_camera_measures_at_half_the_objects_height():
    cell = build_cell(setup("world=toy", "robot=tool", "object=meat", "push.contact_margin=0.003"))
    assert cell.camera.plane_z == pytest.approx(0.003 + 0.01 / 2)
    assert cell.world.camera is cell.camera


def test_object_sheet_reaches_stop_bounds_mask_and_time_step():
    made = setup("object=meat")
    task, sheet = made.task, made.object
    assert task.stop.e_gamma == sheet.e_gamma_stop
    assert tuple(task.goal.mask) == tuple(sheet.goal_mask)
    assert tuple(made.bounds.d) == tuple(sheet.d)
    assert made.world.engine.dt == sheet.dt


def test_a_push_is_laid_out_with_the_margin_of_the_world():
    assert build_cell(setup(*TOY, "world.margin=0.0015")).layout.contact_margin == 0.0015
    own = [*TOY, "world.margin=0.0015", "push.contact_margin=0.003"]
    assert build_cell(setup(*own)).layout.contact_margin == 0.003


def test_without_jitter_the_object_is_as_its_sheet_says():
    assert vary(MADE.object, Draw()) == MADE.object
    assert varied(MADE) == (MADE.object, Draw())


def test_a_draw_moves_turns_and_scales_the_object():
    sheet = MADE.object
    changed = vary(sheet, Draw((0.01, -0.02), 7.0, (0.5, 0.5), 90.0, (1.1, 0.9, 1.2)))
    assert changed.start == pytest.approx((0.59, -0.12))
    assert changed.start_deg == 7.0
    assert changed.material.youngs_modulus == pytest.approx(1.1e4)
    assert changed.material.friction == pytest.approx(0.45)
    assert changed.material.mass == pytest.approx(0.24)
    unchanged = ("start", "start_deg", "material")
    assert replace(changed, **{name: getattr(sheet, name) for name in unchanged}) == sheet


def test_jitter_follows_the_seed_and_moves_the_object():
    drawn = {seed: setup(*TOY, "task.jitter=true", f"seed={seed}") for seed in (4, 5)}
    draw, other = (varied(made)[1] for made in drawn.values())
    assert varied(drawn[4])[1] == draw != other
    assert draw == MADE.task.jitter_range.draw(generator(4, "task"))
    world = build_cell(drawn[4]).world
    np.testing.assert_allclose(world.c, np.array([0.58, -0.1]) + draw.start_shift, atol=1e-9)
    assert np.degrees(world.theta) == pytest.approx(draw.start_turn_deg)
    episode = begun(drawn[4])
    np.testing.assert_allclose(
        episode.target.c, episode.record.view.seen.c + np.array([0.0, 0.2]) + draw.goal_shift
    )


def test_jitter_does_not_change_what_the_optimizer_draws():
    still, moved = (
        build_optimizer(setup(*TOY, "optimizer=random", *more)) for more in ([], ["task.jitter=true"])
    )
    np.testing.assert_array_equal(still.ask().u, moved.ask().u)


@pytest.mark.parametrize(("last", "closed"), [(450.0, True), (400.0, False)])
def test_the_optimizer_knows_whether_the_contour_is_closed(last, closed, monkeypatch):
    built = {}

    def components(**given):
        built.update(given)
        return Components(**given)

    monkeypatch.setattr(assemble, "Components", components)
    build_optimizer(setup(*TOY, f"object.effective.last_deg={last}"))
    assert built["closed"] is closed


def test_a_budget_below_the_initial_samples_is_refused():
    with pytest.raises(UserError, match=r"^optimizer.S0 = 10: must not exceed the budget max_pushes = 9"):
        build_optimizer(setup(*TOY, "max_pushes=9"))
    assert begun(setup(*TOY, "max_pushes=10")).max_pushes == 10


def test_what_recorders_are_told(tmp_path):
    made = setup(*TOY, "object=meat", "seed=3")
    episode = begun(made)
    info = describe(made, episode)
    assert info.title == "meat, abo, seed 3"
    assert (info.initial_samples, info.max_pushes, info.options["model"]) == (10, 80, "error")
    (tmp_path / "config.yaml").write_text(info.config_yaml)
    assert read_config(tmp_path / "config.yaml") == made.values
    assert [info.stop.value(term) for term in TERMS] == info.stops().tolist()
    np.testing.assert_allclose(info.stops(), [0.02, np.radians(7), made.object.e_gamma_stop])
    np.testing.assert_allclose(info.error_stops(), [0.1, 7 / 180, made.object.e_gamma_stop])
    assert info.target is episode.target
    np.testing.assert_array_equal(info.scenery.mesh_triangles, episode.cell.world.mesh.surface())


def untouched(monkeypatch) -> None:
    """Nothing may be pushed."""
    monkeypatch.setattr(ToyWorld, "push", lambda self, path: pytest.fail("something moved"))


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (
            ["object=fish_fillet", "optimizer=abo", "acquisition=safe_lcb"],
            "world=toy: offers no strain, which optimizer=abo with acquisition=safe_lcb needs",
        ),
        (
            ["object=fish_fillet", "optimizer=abo_motion", "acquisition=safe_lcb"],
            "world=toy: offers no strain, which optimizer=abo_motion with acquisition=safe_lcb needs",
        ),
    ],
)
def test_a_world_without_strain_is_refused_before_anything_moves(settings, line, monkeypatch, tmp_path):
    untouched(monkeypatch)
    with pytest.raises(UserError) as caught:
        make_run(setup(*TOY, *settings), tmp_path / "run")
    assert str(caught.value) == line
    assert not (tmp_path / "run").exists()


def test_what_a_camera_sees_needs_no_strain():
    safe = ["acquisition=safe_lcb", "acq.signal=contour", "object=fish_fillet"]
    episode = begun(setup(*TOY, *safe))
    assert episode.optimizer.needs == {"film"}


def test_an_oracle_in_a_world_without_branches_is_refused_before_anything_moves(monkeypatch, tmp_path):
    untouched(monkeypatch)
    monkeypatch.setattr(ToyWorld, "offers", frozenset({"film"}))
    with pytest.raises(UserError) as caught:
        make_run(setup(*TOY, "optimizer=oracle"), tmp_path / "run")
    line = "world=toy: offers no branches, which optimizer=oracle with acquisition=lcb needs"
    assert str(caught.value) == line
    assert not (tmp_path / "run").exists()


def test_all_that_is_missing_is_named_at_once(monkeypatch):
    monkeypatch.setattr(ToyWorld, "offers", frozenset())
    made = setup(*TOY, "optimizer=oracle")

    class Demanding(type(build_optimizer(made))):
        needs = frozenset({"branches", "film"})

    demanding = replace(made, optimizer=lambda parts: Demanding(parts))
    with pytest.raises(UserError, match=r"^world=toy: offers no branches and no film, which optimizer="):
        begin(demanding, build_cell(demanding), build_optimizer(demanding))


@pytest.mark.parametrize(
    ("choice", "optimizer"),
    [
        ("acquisition=safe_lcb", "random"),
        ("acquisition=ei", "greedy"),
        ("model=motion", "random"),
        ("mean=rigid_push", "random"),
        ("kernel=rbf", "greedy"),
        ("fit=fixed", "random"),
        ("minimiser=bfgs", "random"),
        ("design=sobol", "random"),
    ],
)
def test_an_option_that_the_optimizer_does_not_use_is_refused_and_not_ignored(choice, optimizer):
    made = setup(*TOY, "object=fish_fillet", choice, f"optimizer={optimizer}")
    with pytest.raises(UserError) as caught:
        build_optimizer(made)
    line = f"{choice}: optimizer={optimizer} does not use it; leave it out, or choose another optimizer"
    assert str(caught.value) == line


def test_what_an_experiment_chose_for_another_optimizer_does_no_harm():
    """It names the defaults, which are chosen anyway."""
    assert build_optimizer(setup("experiment=rect_straight", "optimizer=random")).S0 == 0


@pytest.mark.parametrize(
    ("argv", "start"),
    [
        (
            ["world=toy", "robot=tool", "object=fish_fillet", "acquisition=safe_lcb"],
            "world=toy: offers no strain",
        ),
        (["object=fish_fillet", "acquisition=safe_lcb", "optimizer=random"], "acquisition=safe_lcb: opt"),
        (["sim=toy"], "sim=toy: the group sim is called world now: world=toy"),
        (["world=toy", "sim.margin=1"], "sim.margin=1: the group sim is called world now: world.margin=1"),
    ],
)
def test_a_refusal_is_one_line_and_leaves_nothing_behind(argv, start, tmp_path):
    """No push, no folder."""
    line = [sys.executable, "-m", "deformpush", *argv, "hydra.run.dir=here"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(line, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith(start)
    assert list(tmp_path.iterdir()) == []


def test_a_group_without_a_choice_has_no_option():
    """No run is one of an experiment called None."""
    assert "experiment" not in MADE.options
    assert setup("experiment=rect_straight", *TOY).options["experiment"] == "rect_straight"


def test_a_configuration_is_read_once():
    """Nothing behind `read` sees it: what changes in it then changes nothing."""
    cfg = compose(TOY)
    made = read(cfg)
    before = made.yaml
    cfg.seed, cfg.object.thickness, cfg[config.OPTIONS].object = 9, 0.5, "meat"
    assert (made.seed, made.object.thickness, made.options["object"]) == (0, 0.02, "rect")
    assert made.yaml == before
