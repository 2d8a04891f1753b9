"""Which classes a configuration may name: those of deformpush, and those of folders that the user named."""

import json
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from deformpush.config.groups import suggest
from deformpush.config.schema import ConfigError
from deformpush.errors import UserError

PACKAGE = "deformpush"
_trusted: list[Path] = []


def trust(folder: Path) -> None:
    """Let components be classes of files in this folder, which the user named on the command line."""
    folder = folder.resolve()
    if folder not in _trusted:
        _trusted.append(folder)
        sys.path.append(str(folder))


def use_config_dir(folder: str) -> str:
    """Trust a folder of the user's; returns the setting by which Hydra finds its YAML files.

    Raises:
        UserError: there is no such folder.
    """
    path = Path(folder).resolve()
    if not path.is_dir():
        raise UserError(f"--config-dir {folder}: no such folder")
    trust(path)
    return f"hydra.searchpath=[{json.dumps(f'file://{path}')}]"


def locate(target: object, where: str) -> type:
    """Import the class that a configuration names. Its name is checked before anything is imported.

    Args:
        target: `package.module.Class`.
        where: the key that names it, for messages.

    Raises:
        ConfigError: it is no class of deformpush or of a trusted folder.
    """
    where = f"{where} = {target}"
    module_name, _, name = str(target).rpartition(".")
    if not module_name or not all(part.isidentifier() for part in str(target).split(".")):
        raise ConfigError(f"{where}: must be package.module.Class")
    if module_name.partition(".")[0] != PACKAGE:
        _refuse_foreign(module_name, where)
    try:
        module = import_module(module_name)
    except ImportError as error:
        raise ConfigError(f"{where}: cannot be imported: {error}") from error
    cls = getattr(module, name, None)
    if not isinstance(cls, type) or cls.__module__ != module_name:
        classes = [word for word, value in vars(module).items() if isinstance(value, type)]
        raise ConfigError(f"{where}: {module_name} has no class {name}{suggest(name, classes)}")
    return cls


def _refuse_foreign(module_name: str, where: str) -> None:
    """Make sure that a module lies in a trusted folder and that Python would take it from there.

    Raises:
        ConfigError: it does not.
    """
    top, *below = module_name.split(".")
    for folder in _trusted:
        path = folder.joinpath(top, *below)
        if path.with_suffix(".py").is_file() or (path / "__init__.py").is_file():
            break
    else:
        known = f"nor a file in {', '.join(map(str, _trusted))}" if _trusted else ""
        hint = "" if _trusted else "; classes of your own come from a folder named with --config-dir"
        raise ConfigError(f"{where}: is not a class of deformpush {known}".rstrip() + hint)
    loaded = sys.modules.get(top)
    origin = getattr(loaded, "__file__", None) if loaded else getattr(find_spec(top), "origin", None)
    if origin is None or folder not in Path(origin).resolve().parents:
        raise ConfigError(f"{where}: another module is called {top} too; give yours another name")
