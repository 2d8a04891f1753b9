"""From a composed configuration to a run: builds the parts, runs them, says how it went."""

import logging
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from omegaconf import DictConfig

from deformpush import config
from deformpush.cell import Cell
from deformpush.console import Progress, closing_lines, orderly_end
from deformpush.errors import TroubleError, UserError
from deformpush.optimizer.protocol import Optimizer, Parts
from deformpush.push import EffectiveContour
from deformpush.record import past as records
from deformpush.record.condition import condition
from deformpush.record.folder import RunFolder
from deformpush.record.push_record import RunInfo
from deformpush.record.recorder import Recorder
from deformpush.retrace import catch_up
from deformpush.runner import Episode, run, start
from deformpush.seeding import generator
from deformpush.sim.object import SoftObject
from deformpush.task import Draw

if TYPE_CHECKING:
    from deformpush.sim.gates import Bench

log = logging.getLogger(__name__)

EXIT_CODES = {"reached": 0, "budget": 0, "failed": 1, "interrupted": 130}


def execute(cfg: DictConfig, run_dir: str | Path) -> int:
    """Run what `cfg` describes in `run_dir` and return the exit code.

    Raises:
        UserError: a setting is wrong or the folder cannot be used; no result has been written.
        TroubleError: the results could not be written to the end; what there is stays.
    """
    config.check(cfg)
    cell = build_cell(cfg)
    with closing(cell.world), orderly_end():
        episode = Episode(cell, start(cell))
        folder = RunFolder.create(run_dir, config.dump(cfg))
        recorder = config.build(cfg.record, folder=folder)
        info = describe(cfg, episode)
        log.info("%s: %d pushes at most, into %s", info.title, cell.max_pushes, folder.path)
        with Progress(cell.max_pushes) as progress:
            return _finish(episode, recorder, lambda: recorder.open(info, episode.first), progress)


def resume(run_dir: str | Path) -> int:
    """Continue the run in `run_dir`, as if it had never stopped, and return the exit code.

    The pushes that were made are made again by the simulator, whose soft body can be restored in no other
    exact way; the optimizer takes up its checkpoint. Nothing in the folder changes before all is as it was.

    Raises:
        UserError: there is no run to continue, or another process works on it.
        DivergedError: the pushes do not repeat themselves.
    """
    folder = RunFolder(Path(run_dir))
    if not folder.path.is_dir():
        raise UserError(f"{folder.path}: no such folder")
    if (ended := condition(folder)).state == "done":
        print(f"{folder.path}: nothing to resume, it ended: {ended.text}")
        return 0
    cfg = reload(folder)
    lock = folder.lock()
    try:
        past = read_past(folder)
        cell = rebuild(cfg, folder)
        with closing(cell.world), orderly_end():
            episode = Episode(cell, start(cell))
            recorder = config.build(cfg.record, folder=folder)
            info = describe(cfg, episode)
            with Progress(cell.max_pushes) as progress:
                if not past.rows:
                    return _finish(
                        episode, recorder, lambda: recorder.open(info, episode.first, lock), progress
                    )
                again = catch_up(episode, past, progress)
                log.info("%s: taken up after push %d, in %s", info.title, past.pushes, folder.path)
                return _finish(episode, recorder, lambda: recorder.reopen(info, past, again, lock), progress)
    finally:
        lock.release()


def read_past(folder: RunFolder) -> records.Past:
    """What a run left, for those who take it up.

    Raises:
        UserError: its table cannot be read.
    """
    try:
        return records.read(folder)
    except OSError as error:
        raise UserError(f"{folder.table}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise UserError(str(error)) from error


def reload(folder: RunFolder) -> DictConfig:
    """The configuration a run was made with.

    Raises:
        UserError: there is none, it is damaged, or of a version that this one does not understand.
    """
    if not folder.config.exists():
        raise UserError(f"{folder.path}: no {folder.config.name}, so there is no run to take up")
    cfg = config.load(folder.config)
    with _said_of(folder.config):
        config.check(cfg)
        if missing := {"object", "task", "optimizer", "record", config.OPTIONS, *config.PLAIN} - set(cfg):
            raise UserError(f"{', '.join(sorted(missing))}: missing; of another version, or no run's")
    return cfg


def rebuild(cfg: DictConfig, folder: RunFolder) -> Cell:
    """The cell of a run that was made with `cfg`.

    Raises:
        UserError: a setting is not understood; the message names the file.
    """
    with _said_of(folder.config):
        return build_cell(cfg)


@contextmanager
def _said_of(file: Path) -> Iterator[None]:
    """Name the file whose settings are complained of."""
    try:
        yield
    except UserError as error:
        raise UserError(f"{file}: {error}") from error


def _finish(episode: Episode, recorder: Recorder, begin: Callable[[], object], progress: Progress) -> int:
    """Run to the end, say how it went and return the exit code."""
    path = recorder.folder.path
    try:
        summary = run(episode, recorder, begin, progress)
    except KeyboardInterrupt:
        print(f"{path}: stopped; {_resume_hint(path)}", file=sys.stderr)
        raise
    except OSError as error:
        why = error.strerror or str(error)
        raise TroubleError(
            f"{path}: cannot be written any more ({why}); the pushes before are kept, {_resume_hint(path)}"
        ) from error
    log.info("%s after %d pushes: %s", summary.status, summary.pushes, summary.reason)
    print(closing_lines(summary, path))
    return EXIT_CODES[summary.status]


def _resume_hint(path: Path) -> str:
    return f"`python -m deformpush resume {shlex.quote(str(path))}` goes on"


def build_cell(cfg: DictConfig) -> Cell:
    """Build everything the loop works with, the object varied as the seed says.

    Raises:
        UserError: names the setting that is wrong.
    """
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
    world = config.build(cfg.sim).build(sheet, robot, camera, push.tool_radius)
    return Cell(world, camera, perception, push, sheet.effective, task, draw, optimizer, cfg.max_pushes)


def build_bench(overrides: Sequence[str]) -> "Bench":
    """Build what the physics gates examine.

    Raises:
        UserError: names the setting that is wrong, or says that the gates need `sim=bullet`.
    """
    from deformpush.composition import compose
    from deformpush.sim.bullet import Bullet
    from deformpush.sim.gates import Bench

    cfg = compose(["robot=tool", *overrides])
    sim = config.build(cfg.sim)
    if not isinstance(sim, Bullet):
        raise UserError(f"sim = {cfg.options.sim}: the physics gates need sim=bullet")
    camera, push = config.build(cfg.camera), config.build(cfg.push)
    return Bench(
        sim, config.build(cfg.object), config.build(cfg.robot), camera, push.tool_radius, tuple(overrides)
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
        **cell.world.scenery(),
    )
