"""From a composed configuration to the parts of a run."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.assemble import build_bench, build_cell, vary
from deformpush.experiment.seeding import generator
from deformpush.task import Draw

TOY = ["world=toy", "robot=tool"]
CFG = compose(TOY)


def test_the_camera_measures_at_half_the_objects_height():
    cell = build_cell(compose(["world=toy", "robot=tool", "object=meat", "push.contact_margin=0.003"]))
    assert cell.camera.plane_z == pytest.approx(0.003 + 0.01 / 2)
    assert cell.world.camera is cell.camera


def test_object_sheet_reaches_stop_bounds_mask_and_time_step():
    cfg = compose(["object=meat"])
    task, sheet = config.build(cfg.task), config.build(cfg.object)
    assert task.stop.e_gamma == sheet.e_gamma_stop
    assert tuple(task.goal.mask) == tuple(sheet.goal_mask)
    assert tuple(config.build(cfg.bounds).d) == tuple(sheet.d)
    assert config.build(cfg.world).engine.dt == sheet.dt
    assert config.build(cfg.push).contact_margin == config.build(cfg.world).margin


def test_without_jitter_the_object_is_as_its_sheet_says():
    sheet = config.build(CFG.object)
    assert vary(sheet, Draw()) == sheet
    assert build_cell(CFG).draw == Draw()


def test_a_draw_moves_turns_and_scales_the_object():
    sheet = config.build(CFG.object)
    varied = vary(sheet, Draw((0.01, -0.02), 7.0, (0.5, 0.5), 90.0, (1.1, 0.9, 1.2)))
    assert varied.start == pytest.approx((0.59, -0.12))
    assert varied.start_deg == 7.0
    assert varied.material.youngs_modulus == pytest.approx(1.1e4)
    assert varied.material.friction == pytest.approx(0.45)
    assert varied.material.mass == pytest.approx(0.24)
    unchanged = ("start", "start_deg", "material")
    assert replace(varied, **{name: getattr(sheet, name) for name in unchanged}) == sheet


def test_jitter_follows_the_seed_and_moves_the_object():
    jittered = compose([*TOY, "task.jitter=true", "seed=4"])
    cell, again, other = (
        build_cell(c) for c in (jittered, jittered, compose([*TOY, "task.jitter=true", "seed=5"]))
    )
    assert cell.draw == again.draw != other.draw
    assert cell.draw == config.build(CFG.task).jitter_range.draw(generator(4, "task"))
    shift = np.array(cell.draw.start_shift)
    np.testing.assert_allclose(cell.world.c, np.array([0.58, -0.1]) + shift, atol=1e-9)
    assert np.degrees(cell.world.theta) == pytest.approx(cell.draw.start_turn_deg)


def test_jitter_does_not_change_what_the_optimizer_draws():
    still, moved = (
        build_cell(compose([*TOY, "optimizer=random", *more])) for more in ([], ["task.jitter=true"])
    )
    np.testing.assert_array_equal(still.optimizer.ask().u, moved.optimizer.ask().u)


@pytest.mark.parametrize(("last", "closed"), [(450.0, True), (400.0, False)])
def test_the_optimizer_knows_whether_the_contour_is_closed(last, closed, monkeypatch):
    built = {}
    whole = config.build

    def build(node, *args, **runtime):
        built.update(runtime)
        return whole(node, *args, **runtime)

    monkeypatch.setattr(config, "build", build)
    build_cell(compose([*TOY, f"object.effective.last_deg={last}"]))
    assert built["parts"].closed is closed


def test_a_budget_below_the_initial_samples_is_refused():
    with pytest.raises(UserError, match=r"^optimizer.S0 = 10: must not exceed the budget max_pushes = 9"):
        build_cell(compose([*TOY, "max_pushes=9"]))
    assert build_cell(compose([*TOY, "max_pushes=10"])).max_pushes == 10


def test_the_gates_take_the_parts_of_the_configuration():
    bench = build_bench(["object=meat", "world.margin=0.001"])
    assert bench.sheet.thickness == 0.01
    assert bench.world.margin == 0.001
    assert type(bench.tool).__name__ == "BareTool"
    assert bench.overrides == ("object=meat", "world.margin=0.001")


def test_the_gates_need_the_real_engine():
    with pytest.raises(UserError, match=r"^sim = toy: the physics gates need world=bullet"):
        build_bench(["world=toy"])
