"""From a composed configuration to the parts of a run."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from omegaconf import DictConfig

from deformpush.cell.cell import Cell
from deformpush.cell.object import SoftObject
from deformpush.cell.push import EffectiveContour
from deformpush.config import build as config
from deformpush.errors import UserError
from deformpush.experiment.seeding import generator
from deformpush.loop import Episode
from deformpush.optimizer.protocol import Optimizer, Parts
from deformpush.push_record import RunInfo
from deformpush.task import Draw

if TYPE_CHECKING:
    from deformpush.checks.physics import Bench


def build_cell(cfg: DictConfig) -> Cell:
    """Build everything the loop works with, the object varied as the seed says.

    Raises:
        UserError: names the setting that is wrong.
    """
    cv2.setNumThreads(1)  # it alone does not ask OMP_NUM_THREADS; parallel runs are not to fight for cores
    task = config.build(cfg.task)
    draw = task.draw(generator(cfg.seed, "task"))
    sheet: SoftObject = vary(config.build(cfg.object), draw)
    optimizer = build_optimizer(cfg, sheet.effective)
    if cfg.max_pushes < optimizer.S0:
        raise UserError(
            f"optimizer.S0 = {optimizer.S0}: must not exceed the budget max_pushes = {cfg.max_pushes}, "
            "which includes the initial samples"
        )
    push = config.build(cfg.push)
    camera = replace(config.build(cfg.camera), plane_z=push.contact_margin + sheet.thickness / 2)
    perception = config.build(cfg.contour)
    robot = config.build(cfg.robot)
    world = config.build(cfg.world).build(sheet, robot, camera, push.tool_radius)
    return Cell(world, camera, perception, push, sheet.effective, task, draw, optimizer, cfg.max_pushes)


def build_bench(overrides: Sequence[str]) -> "Bench":
    """Build what the physics gates examine.

    Raises:
        UserError: names the setting that is wrong, or says that the gates need `world=bullet`.
    """
    from deformpush.checks.physics import Bench
    from deformpush.config.compose import compose
    from deformpush.worlds.bullet.world import Bullet

    cfg = compose(["robot=tool", *overrides])
    spec = config.build(cfg.world)
    if not isinstance(spec, Bullet):
        raise UserError(f"world = {cfg.options.world}: the physics gates need world=bullet")
    camera, push = config.build(cfg.camera), config.build(cfg.push)
    return Bench(
        spec, config.build(cfg.object), config.build(cfg.robot), camera, push.tool_radius, tuple(overrides)
    )


def build_optimizer(cfg: DictConfig, part: EffectiveContour) -> Optimizer:
    """Build the optimizer from its groups."""
    groups = ("bounds", "kernel", "mean", "fit", "model", "minimiser", "design")
    parts: dict[str, Any] = {name: config.build(cfg[name]) for name in groups}
    parts["acquisition"] = config.build(cfg.acq)
    rng = generator(cfg.seed, "optimizer")
    optimizer: Optimizer = config.build(cfg.optimizer, parts=Parts(rng=rng, closed=part.closed, **parts))
    return optimizer


def vary(sheet: SoftObject, draw: Draw) -> SoftObject:
    """The object as a variation of the task has it."""
    x, y = sheet.start
    dx, dy = draw.start_shift
    stiffness, friction, mass = draw.material
    return replace(
        sheet,
        start=(x + dx, y + dy),
        start_deg=sheet.start_deg + draw.start_turn_deg,
        material=sheet.material.scaled(stiffness, friction, mass),
    )


def describe(cfg: DictConfig, episode: Episode) -> RunInfo:
    """What the recorder is told about a run."""
    cell, target = episode.cell, episode.target
    options, stop = cfg[config.OPTIONS], cell.task.stop
    return RunInfo(
        title=f"{options.object}, {options.optimizer}, seed {cfg.seed}",
        config_yaml=config.dump(cfg),
        object_name=options.object,
        model=options.model,
        acquisition=options.acquisition,
        optimizer=options.optimizer,
        seed=cfg.seed,
        initial_samples=cell.optimizer.S0,
        max_pushes=cell.max_pushes,
        camera=cell.camera,
        goal_c=target.c,
        goal_theta=target.theta,
        goal_outline=target.outline,
        stop_position_m=stop.position_m,
        stop_angle_rad=stop.angle_rad,
        stop_e_gamma=stop.e_gamma,
        outer_bounds=np.array([cfg.bounds.kappa, cfg.bounds.d]),
        tool_radius=cell.push.tool_radius,
        strain_limit=cfg.object.strain_limit,
        **cell.world.scenery(),
    )
