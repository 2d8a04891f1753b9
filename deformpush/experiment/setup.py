"""What a run is made of: a composed configuration, checked and read once. Nothing behind this reads it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, get_type_hints

from omegaconf import DictConfig

from deformpush.cell.camera import Camera
from deformpush.cell.object import SoftObject
from deformpush.cell.perception import Perception
from deformpush.cell.push import Push
from deformpush.cell.robot import Robot
from deformpush.cell.world import World, WorldSpec
from deformpush.config import build as config
from deformpush.config.groups import option_groups, package, suggest
from deformpush.errors import UserError
from deformpush.gp.fit import Fit
from deformpush.gp.kernels import Kernel
from deformpush.gp.means import Mean
from deformpush.model.base import Model
from deformpush.model.rigid_push import RigidPush
from deformpush.optimizer.acquisition import Acquisition
from deformpush.optimizer.base import Optimizer
from deformpush.optimizer.bounds import Bounds
from deformpush.optimizer.design import Design
from deformpush.optimizer.minimiser import Minimiser
from deformpush.record.settings import RecordSettings
from deformpush.task import Task


@dataclass(frozen=True)
class Setup:
    """The components of a run, one for each config group."""

    seed: int
    """Every random stream of the run descends from it."""
    max_pushes: int
    """Budget, initial samples included."""
    options: Mapping[str, str]
    """The chosen option of every config group."""
    object: SoftObject
    robot: Robot
    camera: Camera
    world: WorldSpec | World
    task: Task
    push: Push
    contour: Perception
    model: Model
    kernel: Kernel
    mean: Mean | RigidPush
    fit: Fit
    acq: Acquisition
    bounds: Bounds
    design: Design
    minimiser: Minimiser
    optimizer: Callable[..., Optimizer]
    """Called with `parts=Components(...)`."""
    record: RecordSettings
    values: Mapping[str, Any]
    """All settings as plain values, as config.yaml has them."""

    GROUPS: ClassVar[tuple[str, ...]]
    """Top-level keys of the components."""

    @property
    def yaml(self) -> str:
        """What config.yaml holds."""
        return config.dump(self.values)


PLAIN = ("seed", "max_pushes", "options", "values")
Setup.GROUPS = tuple(item.name for item in fields(Setup) if item.name not in PLAIN)


def read(cfg: DictConfig) -> Setup:
    """Check a composed configuration and build its components.

    Raises:
        UserError: names the setting that is wrong.
    """
    config.check(cfg)
    known = {*Setup.GROUPS, *config.PLAIN, config.OPTIONS}
    if strange := sorted(set(map(str, cfg)) - known):
        hint = suggest(strange[0], known)
        if strange[0] in option_groups():
            key = package(strange[0])
            hint = (
                f"; this group's settings stand under {key}: begin its file with the line `# @package {key}`"
            )
        raise UserError(f"{strange[0]}: unknown{hint}; groups and settings: {', '.join(sorted(known))}")
    if absent := sorted({*Setup.GROUPS, *config.PLAIN} - set(map(str, cfg))):
        raise UserError(f"{absent[0]}: missing; every run has one")
    parts: dict[str, Any] = {}
    kinds = get_type_hints(Setup)
    for name in Setup.GROUPS:
        if name == "optimizer":
            parts[name] = config.component(cfg[name], name, ("parts",), Optimizer)
        else:
            parts[name] = config.component(cfg[name], name, kind=kinds[name])()
    chosen = cfg[config.OPTIONS].items()
    options = {str(group): str(option) for group, option in chosen if option is not None}
    values = config.plain(cfg)
    return Setup(
        seed=values["seed"], max_pushes=values["max_pushes"], options=options, values=values, **parts
    )


def refuse_unused(options: Mapping[str, str], optimizer: Optimizer) -> None:
    """Refuse a chosen option that makes no difference to the optimizer.

    Raises:
        UserError: names the choice.
    """
    usual = {group: found[0] for group, found in option_groups().items()}
    for group in ("acquisition", "model", "kernel", "mean", "fit", "bounds", "design", "minimiser"):
        if options.get(group) not in (None, usual[group]) and group not in optimizer.uses:
            raise UserError(
                f"{group}={options[group]}: optimizer={options.get('optimizer')} does not use it; "
                "leave it out, or choose another optimizer"
            )
