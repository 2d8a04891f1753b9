"""config.yaml of a stranger's run: settings and nothing else, all of them, of the classes that fit."""

import os
import shutil
import sys
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import pytest
import yaml

from deformpush.cli.replay import main as replay
from deformpush.errors import UserError
from deformpush.experiment.run import existing, reload, resume
from deformpush.experiment.setup import read
from tests.experiment.test_resume import RUN
from tests.setups import setup


@pytest.fixture
def run(tmp_path) -> Path:
    """A run of which nothing but its configuration is there."""
    (tmp_path / "config.yaml").write_text(RUN.yaml)
    return tmp_path


def refused(run: Path) -> str:
    """The one line by which both verbs refuse a configuration, the name of its file left out."""
    lines = []
    for attempt in (lambda: resume(run), lambda: replay([str(run)])):
        with pytest.raises(UserError) as caught:
            attempt()
        lines.append(caught.value.line)
        assert caught.value.exit_code == 2
    assert lines[0] == lines[1]
    assert "\n" not in lines[0]
    where = f"{run / 'config.yaml'}: "
    assert lines[0].startswith(where)
    return lines[0].removeprefix(where)


def changed(run: Path, change: Callable[[dict], object]) -> Path:
    values = yaml.safe_load((run / "config.yaml").read_text())
    change(values)
    (run / "config.yaml").write_text(yaml.safe_dump(values, sort_keys=False))
    return run


def test_what_a_run_wrote_is_read_as_it_was(run):
    made = reload(existing(run))
    assert made.values == RUN.values
    assert made.options == RUN.options
    assert (made.object, made.push, made.task, made.kernel) == (RUN.object, RUN.push, RUN.task, RUN.kernel)


def test_no_run_changes_what_another_reads(run):
    reload(existing(run)).values["task"]["weights"]["k_c"] = 99.0
    assert reload(existing(run)).values == RUN.values


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("seed: 3", "seed: ${oc.env:HOME}", "the interpolation ${oc.env:HOME}"),
        ("seed: 3", "seed: &a 3", "an alias or anchor"),
        ("seed: 3", "seed: !!python/name:os.system 3", "the tag tag:yaml.org,2002:python/name:os.system"),
        ("seed: 3", "seed: 3\nseed: 3", "seed stands twice"),
        ("seed: 3", "seed: [", "did not find expected"),
        ("seed: 3", "seed: 3\n<<: {a: 1}", "a key that is no name"),
        ("seed: 3", "seed: '3'", 'seed = "3": must be a whole number of 0 or more'),
        ("seed: 3", f"seed: 3 #{'x' * 1_100_000}", "cannot be read (larger than 1 MB)"),
    ],
)
def test_more_than_plain_settings_is_refused(old, new, line, run):
    text = (run / "config.yaml").read_text()
    assert old in text
    (run / "config.yaml").write_text(text.replace(old, new))
    assert line in refused(run)


@pytest.mark.parametrize("content", [b"- 1\n", b"\xff\xfe\x00", b"", b"text"])
def test_what_is_no_configuration_is_refused(content, run):
    (run / "config.yaml").write_bytes(content)
    refused(run)


def leaves(values: dict, above: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """The keys of every setting, `_target_` aside."""
    found = []
    for name, value in values.items():
        inner = isinstance(value, dict) and above[:1] != ("options",)
        found += leaves(value, (*above, name)) if inner else [(*above, name)] * (name != "_target_")
    return found


def within(values: dict, path: tuple[str, ...]) -> dict:
    for name in path:
        values = values[name]
    return values


def test_a_setting_missing_at_any_depth_is_refused_by_name(run):
    paths = leaves(dict(RUN.values))
    assert len(paths) > 90
    for path in paths:
        values = deepcopy(dict(RUN.values))
        within(values, path[:-1]).pop(path[-1])
        with pytest.raises(UserError, match=rf"^{'.'.join(path)}: missing"):
            read(values)
    changed(run, lambda values: values["task"]["weights"].pop("k_c"))
    assert refused(run).startswith("task.weights.k_c: missing; ")


def test_an_unknown_setting_at_any_depth_is_refused_by_name(run):
    for path in sorted({path[:-1] for path in leaves(dict(RUN.values)) if len(path) > 1}):
        values = deepcopy(dict(RUN.values))
        within(values, path).update(tool_x=1)
        with pytest.raises(UserError, match=rf"^{'.'.join([*path, 'tool_x'])}: ") as caught:
            read(values)
        assert "\n" not in str(caught.value)
    changed(run, lambda values: values["task"]["weights"].update(k_x=1))
    assert refused(run).startswith("task.weights.k_x: unknown")


@pytest.mark.parametrize(
    ("target", "line"),
    [
        ("psutil.Popen", "is not a class of deformpush"),
        ("numpy.memmap", "is not a class of deformpush"),
        ("wave.Wave_read", "is not a class of deformpush"),
        ("deformpush_x.World", "is not a class of deformpush"),
        ("deformpush.worlds.toy.os", "has no class os"),
        ("deformpush.gp.means.Zero", "must be a WorldSpec or World"),
        ("deformpush.record.lock.Lock", "must be a WorldSpec or World"),
        ("deformpush..toy", "must be package.module.Class"),
        ("../toy", "must be package.module.Class"),
        (3, "must be package.module.Class"),
        (["os"], "must be package.module.Class"),
    ],
)
def test_a_component_is_a_class_of_ours_that_fits_its_group(target, line, run):
    (run / "deformpush_x.py").write_text("raise SystemExit")
    changed(run, lambda values: values["world"].update(_target_=target))
    loaded = {*sys.modules}
    assert line in refused(run)
    assert [name for name in {*sys.modules} - loaded if not name.startswith("deformpush.")] == []


def test_options_are_names(run):
    changed(run, lambda values: values["options"].update(world={"a": 1}))
    assert refused(run) == 'options.world = {"a": 1}: must be text'


def test_what_could_not_be_taken_up_again_is_not_begun():
    with pytest.raises(UserError, match=r"^acq\.w: missing; "):
        setup("world=toy", "~acq.w")


def test_a_pipe_is_not_waited_for(run):
    shutil.move(run / "config.yaml", run / "other.yaml")
    os.mkfifo(run / "config.yaml")
    assert refused(run) == "cannot be read (no regular file)"
