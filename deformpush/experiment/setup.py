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
from deformpush.config.schema import validate
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


def read(cfg: DictConfig | Mapping[str, Any]) -> Setup:
    """Check a configuration, just composed or read back, and build its components.

    Where every chosen option is one of ours, so that its YAML gives every setting, none may be missing.

    Raises:
        UserError: names the setting that is wrong.
    """
    values = config.plain(cfg) if isinstance(cfg, DictConfig) else cfg
    config.check(values)
    groups = option_groups()
    known = {*Setup.GROUPS, *config.PLAIN, config.OPTIONS}
    if strange := sorted(set(values) - known):
        hint = suggest(strange[0], known)
        if strange[0] in groups:
            key = package(strange[0])
            hint = (
                f"; this group's settings stand under {key}: begin its file with the line `# @package {key}`"
            )
        raise UserError(f"{strange[0]}: unknown{hint}; groups and settings: {', '.join(sorted(known))}")
    if absent := sorted(known - set(values)):
        raise UserError(f"{absent[0]}: missing; every run has one")
    options = _options(values[config.OPTIONS], groups)
    whole = all(option in groups[group] for group, option in options.items())
    parts: dict[str, Any] = {}
    kinds = get_type_hints(Setup)
    for name in Setup.GROUPS:
        if name == "optimizer":
            parts[name] = config.component(values[name], name, ("parts",), Optimizer, whole)
        else:
            parts[name] = config.component(values[name], name, kind=kinds[name], whole=whole)()
    return Setup(
        seed=values["seed"], max_pushes=values["max_pushes"], options=options, values=values, **parts
    )


def _options(chosen: Mapping[str, Any], groups: Mapping[str, Any]) -> dict[str, str]:
    """The option of every group; a group may be without one (`experiment`)."""
    for group in sorted({*chosen} ^ {*groups}):
        what = "missing; it names the group's option" if group in groups else "no such group"
        raise UserError(f"{config.OPTIONS}.{group}: {what}")
    return {
        group: validate(option, str, f"{config.OPTIONS}.{group}")
        for group, option in chosen.items()
        if option is not None
    }


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
