"""Finds the folder `conf/`, its groups and the options of each, without Hydra, so that it answers at once."""

import difflib
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from deformpush.config.default_world import default_world
from deformpush.errors import UserError


def conf_dir() -> Path:
    """Return the folder of the YAML files: inside an installed package, beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "conf"
    return inside if inside.is_dir() else package.parent / "conf"


def suggest(word: str, words: Iterable[str]) -> str:
    """Return ' (did you mean X?)', or nothing when no word is close."""
    close = difflib.get_close_matches(word, list(words), 1)
    return f" (did you mean {close[0]}?)" if close else ""


def option_groups(argv: Sequence[str] = ()) -> dict[str, list[str]]:
    """Return the options of every config group, the default one first; Hydra's own groups aside."""
    import yaml

    options: dict[str, set[str]] = {}
    for folder in [conf_dir(), *_config_dirs(argv)]:
        for file in folder.glob("[!.]*/**/*.yaml"):
            group, *rest = file.relative_to(folder).with_suffix("").parts
            if group != "hydra":
                options.setdefault(group, set()).add("/".join(rest))
    entries = yaml.safe_load((conf_dir() / "config.yaml").read_text(encoding="utf-8"))["defaults"]
    default = {g: o for entry in entries if isinstance(entry, dict) for g, o in entry.items()}
    default["world"] = default_world()
    return {g: sorted(o, key=lambda name: (name != default.get(g), name)) for g, o in sorted(options.items())}


def package(group: str) -> str:
    """The key that the settings of a group stand under, as its files say; its own name if they do not."""
    file = next((conf_dir() / group).glob("*.yaml"), None)
    lines = file.read_text(encoding="utf-8").splitlines() if file else []
    return next((line.split()[-1] for line in lines if line.startswith("# @package")), group)


def check_options(chosen: Mapping[str, str | None]) -> None:
    """Refuse an option that is not the plain name of a file in its group: one with `..` reaches elsewhere.

    Args:
        chosen: the option of every group.

    Raises:
        UserError: names the group and its options.
    """
    for group, option in chosen.items():
        if option is not None and any(part in ("", ".", "..") for part in str(option).split("/")):
            known = ", ".join(option_groups().get(group, []))
            raise UserError(f"{group}={option}: must be the name of an option; options of {group}: {known}")


def check_choices(argv: Sequence[str]) -> None:
    """Refuse a list where the name of an option belongs, over which Hydra stumbles, and names of version 0.1.

    Raises:
        UserError: names the group and its options.
    """
    groups = option_groups(argv)
    for text in argv:
        key, _, value = text.partition("=")
        group = key.lstrip("+~").partition("@")[0]
        if group.partition(".")[0] == "sim":
            raise UserError(f"{text}: the group sim is called world now: {text.replace('sim', 'world', 1)}")
        if value.lstrip().startswith(("[", "{")) and (group in groups or "/" in group):
            options = f"; options of {group}: {', '.join(groups[group])}" if group in groups else ""
            raise UserError(f"{text}: needs the name of one option{options}")


def _config_dirs(argv: Sequence[str]) -> list[Path]:
    """Return the folder named by --config-dir DIR, -cd DIR or --config-dir=DIR, if any."""
    after = [value for flag, value in pairwise(argv) if flag in ("--config-dir", "-cd")]
    return [Path(p) for p in after + [a.partition("=")[2] for a in argv if a.startswith("--config-dir=")]]
