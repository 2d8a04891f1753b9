"""From the components of a run to a robot cell, an optimizer and an episode."""

from dataclasses import replace

import cv2
import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.cell import Cell
from deformpush.cell.object import SoftObject
from deformpush.cell.perception import PerceptionError
from deformpush.cell.push import Push
from deformpush.cell.variation import Draw, vary
from deformpush.cell.world import World, WorldError
from deformpush.errors import UserError
from deformpush.experiment.seeding import generator
from deformpush.experiment.setup import Setup, refuse_unused
from deformpush.loop import Episode
from deformpush.optimizer.base import Components, Optimizer
from deformpush.push_record import RunInfo


def varied(setup: Setup) -> tuple[SoftObject, Draw]:
    """The object as the seed varies it, and the whole variation."""
    draw = setup.task.draw(generator(setup.seed, "task"))
    return vary(setup.object, draw), draw


def layout_of(setup: Setup) -> Push:
    """How pushes are laid out, with the contact margin of the world where none is set."""
    push = setup.push
    return push if push.contact_margin is not None else replace(push, contact_margin=setup.world.margin)


def camera_of(setup: Setup) -> Camera:
    """The camera, measuring on the middle of the object's thickness."""
    plane_z = (layout_of(setup).contact_margin or 0.0) + setup.object.thickness / 2
    return replace(setup.camera, plane_z=plane_z)


def build_cell(setup: Setup) -> Cell:
    """Put up the world with the object in it, and what looks at it.

    Raises:
        UserError: the world cannot hold this object or robot.
    """
    cv2.setNumThreads(1)  # it alone does not ask OMP_NUM_THREADS; parallel runs are not to fight for cores
    sheet, _ = varied(setup)
    push, world, camera = layout_of(setup), setup.world, camera_of(setup)
    if not isinstance(world, World):
        try:
            world = world.build(sheet, setup.robot, camera, push.tool_radius)
        except (ValueError, WorldError) as problem:
            raise UserError(f"world={setup.options['world']}: {problem}") from problem
    return Cell(
        world, camera, setup.contour, push, sheet.effective.placed(np.array(sheet.start), sheet.start_deg)
    )


def build_optimizer(setup: Setup) -> Optimizer:
    """Build the optimizer from its groups.

    Raises:
        UserError: they do not go together, or a chosen option makes no difference to it.
    """
    optimizer = setup.optimizer(
        parts=Components(
            bounds=setup.bounds,
            rng=generator(setup.seed, "optimizer"),
            closed=setup.object.effective.closed,
            kernel=setup.kernel,
            mean=setup.mean,
            fit=setup.fit,
            model=setup.model,
            acquisition=setup.acq,
            minimiser=setup.minimiser,
            design=setup.design,
        )
    )
    if setup.max_pushes < optimizer.S0:
        raise UserError(
            f"optimizer.S0 = {optimizer.S0}: must not exceed the budget max_pushes = {setup.max_pushes}, "
            "which includes the initial samples"
        )
    refuse_unused(setup.options, optimizer)
    return optimizer


def begin(setup: Setup, cell: Cell, optimizer: Optimizer) -> Episode:
    """Look at the object, fix the goal, and refuse what cannot be done before anything moves.

    Raises:
        UserError: the world lacks what the optimizer needs, the object is not in the picture, nothing of it
            may be pushed, or the goal cannot be seen or reached.
    """
    if missing := sorted(optimizer.needs - cell.world.offers):
        options = setup.options
        raise UserError(
            f"world={options['world']}: offers no {' and no '.join(missing)}, which "
            f"optimizer={options['optimizer']} with acquisition={options['acquisition']} needs"
        )
    try:
        episode = Episode(cell, setup.task, optimizer, setup.max_pushes, varied(setup)[1])
    except PerceptionError as problem:
        hint = (
            "; camera.centre and camera.field say what it shows" if problem.key == PerceptionError.key else ""
        )
        raise UserError(f"{problem.key}: {problem}{hint}") from problem
    line = episode.state.effective
    if len(line.index) < 2 or line.length[-1] == 0:
        raise UserError(
            "object.effective: gives an effective contour of zero length: its first and its last point are "
            "the same in the first picture, or nothing between them can be pushed; set them further apart"
        )
    _check_goal(episode)
    return episode


def describe(setup: Setup, episode: Episode) -> RunInfo:
    """What recorders are told about a run."""
    cell, options = episode.cell, setup.options
    return RunInfo(
        title=f"{options['object']}, {options['optimizer']}, seed {setup.seed}",
        config_yaml=setup.yaml,
        options=options,
        seed=setup.seed,
        initial_samples=episode.optimizer.S0,
        max_pushes=setup.max_pushes,
        camera=cell.camera,
        target=episode.target,
        stop=setup.task.stop,
        outer_bounds=setup.bounds.outer,
        tool_radius=cell.layout.tool_radius,
        scenery=cell.world.scenery(),
        strain_limit=setup.object.strain_limit,
        force_limit=setup.object.force_limit,
        offers=cell.world.offers,
    )


def _check_goal(episode: Episode) -> None:
    """Refuse a goal that the camera cannot see or the tool cannot reach.

    Raises:
        UserError: names the setting and where the goal lies.
    """
    cell, target = episode.cell, episode.target
    x, y = target.c
    where = f"{episode.task.goal.setting}: the goal at ({x:.3f}, {y:.3f}) m"
    if not cell.camera.sees(target.outline, cell.perception.border_px):
        half = cell.camera.field / 2
        low, high = np.array(cell.camera.centre) - half, np.array(cell.camera.centre) + half
        raise UserError(
            f"{where} is not wholly inside the picture, which shows x {low[0]:.2f} to {high[0]:.2f} m and "
            f"y {low[1]:.2f} to {high[1]:.2f} m"
        )
    around = np.vstack([target.outline, target.c])
    if not cell.world.can_reach(around).all():
        raise UserError(f"{where} has parts out of the robot's reach; move it nearer or use robot=tool")
