"""Composes the configuration outside Hydra's own entry, and says in one line why that could not be done."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from hydra.errors import HydraException, MissingConfigException, OverrideParseException
from omegaconf import DictConfig
from omegaconf.errors import ConfigAttributeError, ConfigKeyError, OmegaConfBaseException

from deformpush.config import default_world
from deformpush.config.build import OPTIONS
from deformpush.config.groups import check_choices, check_options, conf_dir, option_groups, suggest
from deformpush.errors import UserError
from deformpush.extras import needed_extra, not_installed

if TYPE_CHECKING:
    from yaml import MarkedYAMLError


def compose(overrides: Sequence[str]) -> DictConfig:
    """Compose the configuration of a run for a verb or a benchmark, the chosen options included.

    Raises:
        UserError: an override does not fit.
    """
    from hydra import compose as hydra_compose
    from hydra import initialize_config_dir
    from omegaconf import open_dict
    from yaml import MarkedYAMLError

    check_choices(overrides)
    default_world.register()
    try:
        with initialize_config_dir(str(conf_dir().resolve()), version_base="1.3"):
            cfg = hydra_compose("config", list(overrides), return_hydra_config=True)
    except HydraException as error:
        raise UserError(explain(error, overrides)) from error
    except MarkedYAMLError as error:
        raise UserError(not_yaml(error)) from error
    check_options(cfg.hydra.runtime.choices)
    default_world.tell_default(cfg.hydra.runtime.choices, overrides)
    refuse_study(cfg.hydra.runtime.choices, cfg.hydra.sweeper.get("params") or ())
    with open_dict(cfg):
        choices = cfg.pop("hydra").runtime.choices
        del cfg["sweep"]  # how runs are made, not what they are
        cfg[OPTIONS] = {group: option for group, option in choices.items() if "/" not in group}
    return cfg


def refuse_study(options: Mapping[str, str], varied: Iterable[str]) -> None:
    """Refuse to make one run of an experiment that is a study of many.

    Args:
        options: the chosen option of every config group.
        varied: settings that the experiment varies.

    Raises:
        UserError: names the experiment and what it varies.
    """
    if keys := ", ".join(varied):
        raise UserError(f"experiment={options['experiment']}: a study, which varies {keys}; add -m")


def explain(error: HydraException, argv: Sequence[str]) -> str:
    """Return the line for `error`, which Hydra raised for the command line `argv`."""
    groups = option_groups(argv)
    cause = error.__cause__
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        group, _, name = error.missing_cfg_file.rpartition("/")
        if group == "hydra/launcher" and (extra := needed_extra(name)):
            asked = [text.partition("=")[2] for text in argv if text.startswith("hydra/launcher=")]
            return not_installed((asked or [name])[-1], extra)
        return _no_option(error.missing_cfg_file, error.options or groups.get(group) or ())
    if isinstance(error, OverrideParseException):
        return _no_override(error.override, groups)
    if isinstance(cause, (ConfigAttributeError, ConfigKeyError)) and isinstance(
        cause.parent_node, DictConfig
    ):
        return _no_key(str(cause.full_key), cause.parent_node, groups)
    if isinstance(cause, OmegaConfBaseException):
        return f"{cause.full_key}: {str(cause).splitlines()[0]}"
    if str(error).startswith("Ambiguous value for argument"):
        text = str(error).split("'")[1]
        return f"{text}: several values need -m, a run for each; one list is written [1,2]"
    lines = [line.strip() for line in str(error).splitlines()]
    return "; ".join(line.removesuffix(".") for line in lines if line and not line.startswith("See http"))


def not_yaml(error: "MarkedYAMLError") -> str:
    """Return the line for a file of the configuration that is no YAML."""
    mark = error.problem_mark
    where = f"{mark.name}, line {mark.line + 1}" if mark else "configuration"
    return f"{where}: not YAML: {error.problem or error.context}"


def _no_option(path: str, options: Sequence[str]) -> str:
    """Explain a missing file `path` of a group, such as object/fish."""
    group, _, name = path.rpartition("/") if path.startswith("hydra/") else path.partition("/")
    options = options or option_groups().get(group, [])
    known = ", ".join(options) or "none"
    return f"{group}={name}: no such option{suggest(name, options)}; options of {group}: {known}"


def _no_override(text: str, groups: dict[str, list[str]]) -> str:
    """Explain an argument that is not KEY=VALUE."""
    if text in groups:
        options = groups[text]
        return f"{text}: needs an option, as in {text}={options[0]}; options of {text}: {', '.join(options)}"
    return f"{text}: not KEY=VALUE; a list is written [1,2], a text with special signs 'KEY=\"a b\"'"


def _no_key(key: str, parent: DictConfig, groups: dict[str, list[str]]) -> str:
    """Explain a key that does not exist in `parent`."""
    names = [str(name) for name in parent if name not in ("_target_", "hydra")]
    where = parent._get_full_key("")
    if where and not names:
        return f"{key}: unknown; {where} is one value and has no settings of its own"
    if where:
        return f"{key}: unknown{suggest(key.rpartition('.')[2], names)}; {where} has: {', '.join(names)}"
    names = sorted({*names, *groups})
    return f"{key}: unknown{suggest(key, names)}; groups and settings: {', '.join(names)}"
