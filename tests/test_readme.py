"""What README and docs/ tell a newcomer to type works as printed; docs/extending.md has tests of its own.

Every line of every shell block is carried out in an empty folder with a home of its own: runs in the toy
world with few pushes, `make` as far as saying what it would do. A line that opens a window is left out.
"""

import logging
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from hydra import compose as hydra_compose
from hydra import initialize_config_dir

import deformpush
from deformpush import __main__
from deformpush.cell.observation import Observation
from deformpush.cli import object as object_verb
from deformpush.cli import usage
from deformpush.config import default_world
from deformpush.config.groups import conf_dir
from deformpush.experiment.assemble import build_optimizer
from deformpush.experiment.sweep.names import with_folder
from deformpush.gp.kernel import Kernel
from deformpush.optimizer.acquisition import Context
from deformpush.push_record import Action
from deformpush.record.finished import flat
from deformpush.record.table import COLUMNS
from deformpush.state import State
from deformpush.task import TERMS, Target
from deformpush.viewer.headless import has_driver
from tests import photos
from tests.pages import ROOT, blocks, named_files, page, rows, sections, write

README = page("README.md")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
TOY = {"world": "toy", "robot": "tool", "record": "off", "max_pushes": "3"}
"""Added to a run where its line does not say otherwise."""


def shown() -> list[str]:
    """Every line of every shell block, and the variants that comments behind them name."""
    found: list[str] = []
    for path in PAGES:
        if path.name == "extending.md":
            continue
        for line in "".join(blocks(path.read_text(encoding="utf-8"), "sh", "bash", "console")).splitlines():
            words = shlex.split(line, comments=True)
            variant = re.search(r"# or: (\w+ .*)", line)
            found += [shlex.join(words)] if words else []
            found += [f"deformpush {variant[1]}"] if variant else []
    return list(dict.fromkeys(line.replace("python -m deformpush", "deformpush") for line in found))


LINES = shown()


def kind(line: str) -> str:
    """What sort of command a line is."""
    program, *rest = shlex.split(line)
    if program == "make":
        return "make"
    assert program == "deformpush", f"{line}: say in this file how it is tested"
    if rest[0] in usage.VERBS:
        window = rest[0] == "view" and "--screenshot" not in rest
        return "window" if window else "verb"
    if "--config-dir" in rest:
        return "own"
    return "sweep" if "-m" in rest else "run"


def lines(wanted: str) -> list[str]:
    """The lines of one kind."""
    return [line for line in LINES if kind(line) == wanted]


def quick(settings: list[str], **more: str) -> list[str]:
    """Settings with those that make a run short, where they do not say otherwise."""
    given = {text.partition("=")[0] for text in settings}
    added = {name: value for name, value in (TOY | more).items() if name not in given}
    return [*settings, *(f"{name}={value}" for name, value in added.items())]


Shell = Callable[..., str]


@pytest.fixture
def shell(monkeypatch, capfd, tmp_path) -> Any:
    """Carry out a `deformpush` command in this process, in an empty folder; what it printed."""
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.chdir(tmp_path)
    handlers = list(logging.root.handlers)

    def run(*argv: str, code: int = 0) -> str:
        monkeypatch.setattr(sys, "argv", ["deformpush", *argv])
        with pytest.raises(SystemExit) as leaving:
            __main__.main()
        out, err = capfd.readouterr()
        assert leaving.value.code == code, err
        return out + err

    yield run
    for handler in set(logging.root.handlers) - set(handlers):
        handler.close()
    logging.root.handlers[:] = handlers


def test_there_are_lines_of_every_kind():
    assert {kind(line) for line in LINES} == {"make", "run", "sweep", "verb", "own", "window"}
    assert lines("window") == ["deformpush view RUN"]
    assert {shlex.split(line)[1] for line in lines("verb")} == set(usage.VERBS) - {"doctor"}


@pytest.mark.parametrize("line", lines("make"))
def test_make(line):
    """The target exists, and the settings that it hands on fit each other."""
    done = subprocess.run(
        ["make", "-n", *shlex.split(line)[1:]], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 0, done.stderr
    for settings in re.findall(r"-m deformpush\b(.*)", done.stdout):
        build_optimizer(deformpush.compose(*shlex.split(settings)))


@pytest.mark.parametrize("line", lines("run"))
def test_a_run(line, shell, tmp_path):
    settings = shlex.split(line)[1:]
    more = {"optimizer.S0": "2"}
    if "hydra.run.dir=runs/mine" not in settings:
        more["hydra.run.dir"] = "runs/mine"
    if "optimizer.S0=10" in settings:
        more["max_pushes"] = "11"
    shell(*quick(settings, **more))
    assert (tmp_path / "runs" / "mine" / "summary.json").is_file()
    # What was made quick must fit as it stands there, too.
    build_optimizer(deformpush.compose(*[text for text in settings if not text.startswith("hydra.")]))


def of_the_launcher(text: str) -> bool:
    """Whether a setting says how a sweep is made, and not what it is."""
    return text.startswith(("hydra/launcher=", "hydra.launcher."))


def small(line: str) -> tuple[str, ...]:
    """The settings of a sweep with the first seed, two values at most, and without its launcher."""
    settings = [text for text in shlex.split(line)[1:] if not of_the_launcher(text)]
    settings = [re.sub(r"=range.*", "=100", text) for text in settings]
    settings = [re.sub(r"(=[\w.]+,[\w.]+),.*", r"\1", text) for text in settings]
    return tuple(quick(settings, **{"max_pushes": "2", "optimizer.S0": "2", "seed": "100"}))


@pytest.mark.parametrize("settings", dict.fromkeys(map(small, lines("sweep"))), ids=" ".join)
def test_a_sweep(settings, shell, tmp_path):
    told = shell(*settings)
    runs = int(re.findall(r"sweep of (\d+) runs", told)[0])
    assert len(list((tmp_path / "runs").rglob("summary.json"))) == runs >= 1
    assert "failed" not in told


@pytest.mark.parametrize("line", [line for line in lines("sweep") if "hydra/launcher=" in line])
def test_a_launcher(line):
    """Its settings fit each other; tests/experiment/test_launchers.py starts some."""
    default_world.register()
    with initialize_config_dir(str(conf_dir()), version_base="1.3"):
        hydra_compose("config", list(filter(of_the_launcher, shlex.split(line))), return_hydra_config=True)


def test_a_sweeps_folder_is_named_as_the_page_says():
    made = next(line for line in lines("sweep") if "range(100,120)" in line and "object" in line)
    asked = next(line for line in lines("verb") if "range100" in line)
    folder = with_folder(shlex.split(made)[1:])[-1].partition("=")[2].strip("'")
    assert folder == shlex.split(asked)[-1]


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> Path:
    """Two runs in a folder."""
    folder = tmp_path_factory.mktemp("runs")
    for seed in (0, 1):
        settings = quick([], max_pushes="12", record="light", **{"optimizer.S0": "8"})
        deformpush.run(*settings, seed=seed, folder=folder / f"run-{seed}", progress=False)
    return folder


WRITTEN = {
    "compare": ("compare.csv", "compare.png", "compare.rrd"),
    "report": ("report.html",),
    "video": ("run-0/*.mp4",),
    "regret": ("regret.csv", "regret_trials.csv", "regret.png"),
    "object": ("my_conf/object/fish.yaml", "my_conf/object/fish.png"),
    "view": ("a.png",),
}
SAID = {
    "status": "2 runs",
    "replay": "identical: ",
    "whatif": "push 7 of run-0, from the state after push 6",
    "resume": "after 12 pushes",
    "see": "written: ",
    "tune": "best: ",
}


@pytest.mark.parametrize(
    "line",
    [
        pytest.param(
            line,
            marks=[
                pytest.mark.screen,
                pytest.mark.skipif(not has_driver(), reason="a picture needs a Vulkan driver"),
            ]
            if "--screenshot" in line
            else [],
        )
        for line in lines("verb")
    ],
)
def test_a_verb(line, runs, shell, tmp_path):
    shutil.copytree(runs, tmp_path, dirs_exist_ok=True)
    names = iter(("run-0", "run-1"))
    stand_for = {"SWEEP_FOLDER": ".", "FOLDER": "again"}
    verb, *rest = [
        "."
        if text.startswith("runs/sweeps/")
        else stand_for.get(text) or (next(names) if text == "RUN" else text)
        for text in shlex.split(line)[1:]
        if text != "..."
    ]
    if verb == "object":
        shutil.copytree(ROOT / "docs" / "examples", tmp_path / "docs" / "examples")
    if verb == "resume":
        (tmp_path / "run-0" / "summary.json").unlink()
        table = tmp_path / "run-0" / "pushes.csv"
        table.write_bytes(b"".join(table.read_bytes().splitlines(keepends=True)[:-1]))
    if verb == "tune":
        at = rest.index("--trials")
        rest[at + 1] = "1"
        rest += ["--seeds", "100", *quick([], **{"optimizer.S0": "2"})]
        rest = list(dict.fromkeys(rest))
    if verb == "see":
        photos.take(tmp_path, *rest)
        rest = [
            word for text in rest for word in (sorted(map(str, Path().glob(text))) if "*" in text else [text])
        ]
    if verb == "regret":
        rest[rest.index("--pushes") + 1] = "2"
    if verb == "tune" and find_spec("optuna") is None:
        assert "pip install 'deformpush[tune]' brings it" in shell(verb, *rest, code=2)
        return
    told = shell(verb, *rest)
    assert SAID.get(verb, "") in told
    for pattern in WRITTEN.get(verb, ()):
        assert list(tmp_path.rglob(pattern)), f"{pattern} in {os.listdir(tmp_path)}"


@pytest.fixture
def own_files(tmp_path) -> Path:
    """The files that the README shows."""
    write(named_files(README, "yaml", "python"), tmp_path)
    return tmp_path


@pytest.mark.parametrize("line", lines("own"))
def test_own_objects_and_methods_run_as_shown(line, own_files, monkeypatch):
    if "object=fish" in line:
        monkeypatch.chdir(own_files)
        (made,) = (words for words in lines("verb") if words.startswith("deformpush object "))
        object_verb.main([str(ROOT / text) if "/" in text else text for text in shlex.split(made)[2:]])
    more = {"optimizer.S0": "2", "hydra.run.dir": "here", "max_pushes": "2"}
    settings = quick(shlex.split(line)[1:], **more)
    command = [sys.executable, "-m", "deformpush", *settings]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "", "HOME": str(own_files)}
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=own_files, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    config = (own_files / "here" / "config.yaml").read_text(encoding="utf-8")
    assert any(own in config for own in ("youngs_modulus: 30000.0", "inset: 0.2", "object: fish\n"))


def test_the_readme_shows_two_objects_and_a_method():
    assert len(lines("own")) == 3


def test_every_make_target_it_names_exists():
    rules = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"make ([a-z-]+)(?=[ `]|$)", README, re.MULTILINE)) - {"run"} <= set(rules)


def test_every_page_it_names_exists():
    for path in PAGES:
        named = re.findall(r"`(docs/[\w/.]+)`|\]\((?!https?:)([^)#]+)", path.read_text(encoding="utf-8"))
        missing = [a or b for a, b in named if not (ROOT / a if a else path.parent / b).exists()]
        assert missing == [], path.name


GLOSSARY = rows(sections(README)["Symbols and words"])


def test_the_glossary_names_what_there_is():
    settings = set(flat(deformpush.compose().values))
    attributes = {
        f"{cls.__name__}.{name}"
        for cls in (Observation, Target, State, Action, Context, Kernel)
        for name in {*dir(cls), *((item.name for item in fields(cls)) if is_dataclass(cls) else ())}
    }
    named = {name for row in GLOSSARY for name in re.findall(r"`(.*?)`", row["in the code"])}
    assert len(named) > 35
    assert named - settings - attributes - set(COLUMNS) == set()
    assert {column for term in TERMS for column in (term.symbol, term.column)} <= named


def test_the_glossary_gives_each_name_a_unit():
    for row in GLOSSARY:
        assert row["word"], row
        units = row["unit"].split(", ")
        assert set(units) <= {"-", "m", "rad", "pushes"}, row
        assert len(units) in (1, 2, len(row["in the code"].split(", "))), row
