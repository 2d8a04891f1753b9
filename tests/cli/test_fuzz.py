"""Whatever stands in a run folder or on the command line: documented errors, one line, never a traceback."""

import contextlib
import io
import json
import logging
import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from deformpush import __main__
from deformpush.cli import status, usage
from deformpush.config.groups import option_groups
from deformpush.errors import UserError
from deformpush.experiment.run import make_run, resume
from deformpush.experiment.sweep import manifest
from deformpush.experiment.sweep.status import look
from deformpush.record import checkpoint, finished, forecasts, poses, saved_config, summary, table, unfinished
from deformpush.record.folder import RunFolder
from deformpush.record.status import STATES, run_status
from tests.cli.test_cli import stand_in
from tests.experiment.test_resume import TOY, cut
from tests.setups import setup

FEW = settings(max_examples=40, suppress_health_check=list(HealthCheck), deadline=None)


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """A small run with forecasts in it."""
    folder = tmp_path_factory.mktemp("run") / "run"
    make_run(setup(*TOY, "optimizer=abo_motion", "max_pushes=3"), folder)
    return folder


@st.composite
def mutated(draw: st.DrawFn, data: bytes) -> bytes:
    """Bytes with a few places cut, doubled, flipped or replaced."""
    out = bytearray(data)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(0, len(out) - 1)))
        length = draw(st.sampled_from([1, 2, 8, 64, len(out)]))
        kind = draw(st.sampled_from(["cut", "double", "flip", "put"]))
        if kind == "cut":
            del out[at : at + length]
        elif kind == "double":
            out[at:at] = out[at : at + length]
        elif kind == "flip" and out:
            out[at] ^= draw(st.integers(1, 255))
        else:
            out[at : at + length] = draw(
                st.sampled_from([b"", b"\n", b",", b"\x00", b"nan", b"1e999", b"[", b"-", b"\xff"])
            )
    return bytes(out)


def anything(data: bytes) -> st.SearchStrategy[bytes]:
    """Noise, or what a run wrote and something harmed."""
    return st.one_of(st.binary(max_size=200), mutated(data), mutated(data))


READERS = {
    "pushes.csv": [
        (table.read_rows, (OSError, ValueError)),
        (table.read, (OSError, ValueError)),
        (lambda file: unfinished.read(RunFolder(file.parent)), (OSError, ValueError)),
    ],
    "contours.npz": [(poses.read_poses, (OSError, ValueError))],
    "views.npz": [(poses.read_pictures, (OSError, ValueError)), (poses.read_views, (OSError, ValueError))],
    "forecasts.csv": [(forecasts.read, (OSError, ValueError))],
    "checkpoint.npz": [(checkpoint.read, ())],
    "summary.json": [
        (lambda file: run_status(RunFolder(file.parent)), ()),
        (lambda file: summary.read(RunFolder(file.parent)), (FileNotFoundError, ValueError)),
        (lambda file: status.tell(look(file.parent)), ()),
    ],
    "config.yaml": [(saved_config.read_config, (OSError, saved_config.SavedConfigError))],
    "provenance.json": [],
}
"""By file: what reads it, and the errors it may raise."""


@pytest.mark.parametrize("name", READERS)
@FEW
@given(data=st.data())
def test_a_reader_of_run_folders_raises_nothing_but_its_documented_errors(name, data, run):
    with TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        shutil.copytree(run, folder)
        (folder / name).write_bytes(data.draw(anything((run / name).read_bytes())))
        for reader, errors in [*READERS[name], (read_finished, finished.NotFinishedError)]:
            with contextlib.suppress(*(errors if isinstance(errors, tuple) else (errors,))):
                reader(folder / name)
        assert run_status(RunFolder(folder)).state in STATES


def read_finished(file: Path) -> object:
    return finished.read(RunFolder(file.parent), "run")


@FEW
@given(
    content=st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(["jobs", "name", "overrides", "status", "reason", "pushes", "wall_s"]), inner
            )
        ),
        max_leaves=12,
    )
)
@example(content={"status": "reached", "reason": "", "pushes": 3})
@example(content={"status": "reached", "reason": "", "pushes": 3, "wall_s": "long"})
def test_json_of_any_shape_is_told_of(content, tmp_path_factory):
    folder = tmp_path_factory.mktemp("any") / "s"
    (folder / "run").mkdir(parents=True)
    for file in (folder / "sweep.json", folder / "run" / "summary.json"):
        file.write_text(json.dumps(content))
    assert all(isinstance(job.name, str) for job in manifest.read(folder))
    with contextlib.redirect_stdout(io.StringIO()):
        status.main([str(folder)])


@pytest.mark.parametrize("name", ["pushes.csv", "config.yaml", "checkpoint.npz", "summary.json"])
@settings(max_examples=12, suppress_health_check=list(HealthCheck), deadline=None)
@given(data=st.data())
def test_a_harmed_run_is_resumed_or_refused_in_one_line(name, data, run):
    with TemporaryDirectory() as scratch:
        folder = cut(run, Path(scratch) / "run", 2)
        shutil.copy(run / name, folder) if name != "pushes.csv" else None
        harmed = data.draw(mutated((folder / name).read_bytes()))
        assume(
            b"_target_" not in harmed
            or harmed.count(b"_target_") == (run / name).read_bytes().count(b"_target_")
        )
        (folder / name).write_bytes(harmed)
        said = ""
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            try:
                resume(folder)
            except UserError as error:
                said = str(error)
        assert "\n" not in said


GROUPS = option_groups()
KEYS = [
    "seed",
    "acq.w",
    "object",
    "object.d",
    "bounds.kappa",
    "hydra.run.dir",
    "optimizer.S0",
    "+a",
    "~object",
    "x",
]
VALUES = st.one_of(
    st.text(max_size=12),
    st.sampled_from(
        ["1", "-1", "1e999", "nan", "null", "[", "[0,1]", "{a:1}", "${seed}", "${x", "1,2", "'", "range(3)"]
    ),
)
ARGUMENT = st.one_of(
    st.text(max_size=16),
    st.builds("{}={}".format, st.sampled_from(KEYS), VALUES),
    st.builds("{}={}".format, st.sampled_from(sorted(GROUPS)), VALUES),
    st.sampled_from(
        ["-m", "--cfg", "--info", "--package", "-c", "--resolve", "--config-dir", "--", "-", "status"]
    ),
)


@pytest.fixture
def quiet(monkeypatch, tmp_path):
    """No run is made, nothing is left behind."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    stand_in(monkeypatch, lambda made, folder: None)
    handlers, environment = list(logging.root.handlers), dict(os.environ)
    yield
    logging.root.handlers[:] = handlers
    os.environ.clear()
    os.environ.update(environment)


def answer(argv: list[str]) -> tuple[object, str]:
    """Exit code, and what goes to stderr, of a command line."""
    err = io.StringIO()
    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(err),
        contextlib.ExitStack() as stack,
    ):
        stack.callback(setattr, sys, "argv", sys.argv)
        sys.argv = ["deformpush", *argv]
        try:
            __main__.main()
        except SystemExit as leaving:
            return leaving.code, err.getvalue()
    raise AssertionError("it did not exit")


@settings(max_examples=60, suppress_health_check=list(HealthCheck), deadline=None)
@given(argv=st.lists(ARGUMENT.filter(lambda text: "\x00" not in text), min_size=1, max_size=3))
@example(argv=["acq.w=\n"])
@example(argv=["a\nb"])
@example(argv=[""])
@example(argv=["object=../../config"])
@example(argv=["seed=${seed}"])
@example(argv=["--config-dir"])
@example(argv=["--cfg", "all of it"])
@example(argv=["camera=[0,1]"])
def test_no_argument_gives_a_traceback(argv, quiet):
    code, err = answer(argv)
    assert code in (0, 2)
    if code == 2:
        assert err.strip()
        assert err.count("\n") == 1 or argv[0] in usage.VERBS, err
    assert "Traceback" not in err
