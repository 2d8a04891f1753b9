"""Full disks, read-only folders, rivals for a folder, jumping clocks, old files: one line, no push lost."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from omegaconf import OmegaConf

from deformpush.cli import status
from deformpush.cli.replay import main as replay
from deformpush.errors import TroubleError, UserError
from deformpush.experiment.run import make_run, resume
from deformpush.record.folder import parts
from deformpush.record.table import read
from deformpush.viewer.compact import identity_of
from tests.experiment.test_resume import RUN, TIMES, TOY, cut, ended, same
from tests.experiment.test_resume import whole as whole_run
from tests.faults import in_child
from tests.setups import setup

ROOT = Path(__file__).resolve().parents[2]
LIGHT = setup(
    *TOY[:2],
    *TOY[3:],
    "record=light",
    "record.figures=false",
    "record.jpeg_quality=85",
    "max_pushes=16",
    "seed=3",
)
whole = whole_run


def mount(*words: str) -> None:
    """Mount, or skip the test where that is not allowed."""
    if os.geteuid() or subprocess.run(["mount", *words], capture_output=True, check=False).returncode:
        pytest.skip("needs the right to mount")


@contextmanager
def disk(folder: Path, size_kB: int) -> Iterator[Path]:
    """A small disk at `folder`."""
    folder.mkdir()
    mount("-t", "tmpfs", "-o", f"size={size_kB}k", "tmpfs", str(folder))
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """Let nobody write in a folder, root included."""
    mount("--bind", str(folder), str(folder))
    try:
        mount("-o", "remount,ro,bind", str(folder))
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def made_so_far(folder: Path, other: Path) -> int:
    """Pushes in a table, all of which must be those of the other run."""
    rows, others = (read(path / "pushes.csv").drop(columns=TIMES) for path in (folder, other))
    assert rows.equals(others[: len(rows)])
    return len(rows) - 1


@pytest.mark.parametrize("size_kB", [96, 128, 160])
def test_a_full_disk_keeps_the_pushes_before_and_resume_goes_on(size_kB, tmp_path, whole):
    with disk(tmp_path / "small", size_kB) as small:
        with pytest.raises(TroubleError, match=r"cannot be written any more \(No space left on") as caught:
            make_run(RUN, small / "run")
        assert (caught.value.exit_code, str(caught.value).count("\n")) == (1, 0)
        assert 0 < made_so_far(small / "run", whole) < 16
        assert not list((small / "run").glob(".*.tmp")), "no half-written file takes room"
        mount("-o", "remount,size=64m", str(small))
        assert ended(resume(small / "run"))
        same(small / "run", whole)


def test_a_full_disk_while_recording_too(tmp_path, whole):
    with disk(tmp_path / "small", 2900) as small:
        with pytest.raises(TroubleError, match="No space left on device"):
            make_run(LIGHT, small / "run")
        assert 0 < made_so_far(small / "run", whole) < 16
        mount("-o", "remount,size=64m", str(small))
        assert ended(resume(small / "run"))
        same(small / "run", whole)


def test_a_disk_that_is_full_from_the_start_is_one_line(tmp_path):
    with disk(tmp_path / "small", 8) as small:
        with pytest.raises(UserError, match="No space left on device") as caught:
            make_run(RUN, small / "run")
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("limit_kB", [20, 24])
def test_a_limit_on_the_size_of_files_is_one_line_and_exit_code_1(limit_kB, tmp_path, whole):
    settings = [*TOY, "max_pushes=16", "seed=3", "hydra.run.dir=run"]
    line = [sys.executable, "-m", "deformpush", *settings]
    limited = ["sh", "-c", f'ulimit -f {2 * limit_kB}; exec "$@"', "sh", *line]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(limited, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith(
        f"{tmp_path / 'run'}: cannot be written any more (File too large); the pushes "
    )
    assert done.stderr.count("\n") == 1
    assert 0 <= made_so_far(tmp_path / "run", whole) < 16
    assert ended(resume(tmp_path / "run"))
    same(tmp_path / "run", whole)


def test_a_read_only_folder_is_one_line(tmp_path, whole, capsys):
    folder = cut(whole, tmp_path / "sweep" / "run", 12)
    (tmp_path / "sweep" / "sweep.json").write_text('{"jobs": []}')
    before = {file: file.read_bytes() for file in folder.iterdir() if file.is_file()}
    with read_only(tmp_path / "sweep"):
        for attempt in (lambda: resume(folder), lambda: make_run(RUN, tmp_path / "sweep" / "new")):
            with pytest.raises(UserError, match=r"cannot write there \(Read-only file system\)") as caught:
                attempt()
            assert (caught.value.exit_code, str(caught.value).count("\n")) == (2, 0)
        with pytest.raises(TroubleError, match=r"cannot write sweep.csv \(Read-only file system\)"):
            status.main([str(tmp_path / "sweep")])
        capsys.readouterr()
        assert replay([str(folder)]) == 0
        assert capsys.readouterr().out.startswith("identical: 12 pushes")
    assert {file: file.read_bytes() for file in folder.iterdir() if file.is_file()} == before


def at_once(works: list[Callable[[], object]]) -> list[int]:
    """Exit codes of works that children of this process do, begun together."""
    start = time.time() + 0.2

    def on_time(work: Callable[[], object]) -> None:
        time.sleep(max(0.0, start - time.time()))
        try:
            work()
        except UserError as error:
            os._exit(error.exit_code)

    children = [in_child(lambda work=work: on_time(work)) for work in works]
    return [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]


def test_of_two_runs_begun_at_once_in_one_folder_one_is_refused(tmp_path, whole):
    for i in range(5):
        codes = at_once([lambda i=i: make_run(RUN, tmp_path / str(i))] * 2)
        assert sorted(codes) == [0, 2]
        same(tmp_path / str(i), whole)


def test_of_two_that_resume_at_once_one_does(tmp_path, whole):
    for i in range(5):
        folder = cut(whole, tmp_path / str(i), 8)
        codes = at_once([lambda folder=folder: resume(folder)] * 2)
        assert sorted(codes) in ([0, 2], [0, 0]), "the second may come when all is done"
        same(folder, whole)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The same run with a recording."""
    folder = tmp_path_factory.mktemp("recorded") / "run"
    make_run(LIGHT, folder)
    return folder


HARMS = {
    "truncated": lambda data: data[: len(data) // 2],
    "cut": lambda data: data[:-3],
    "empty": lambda data: b"",
    "foreign": lambda data: b"not a recording" * 9,
    "flipped": lambda data: (
        data[: len(data) // 3] + bytes([data[len(data) // 3] ^ 255]) + data[len(data) // 3 + 1 :]
    ),
    "missing": None,
}


@pytest.mark.parametrize("harm", HARMS)
def test_a_damaged_recording_does_not_keep_a_run_from_going_on(harm, tmp_path, recorded, whole):
    folder = cut(recorded, tmp_path / "run", 12)
    file, change = folder / "recording.rrd", HARMS[harm]
    if change is None:
        file.unlink()
    else:
        file.write_bytes(change(file.read_bytes()))
    assert ended(resume(folder))
    same(folder, whole)
    readable = [part for part in parts(file) if identity_of(part) is not None]
    assert readable, "what came after is recorded"


def jumping() -> Callable[[], float]:
    """A clock that goes wrong by days in both directions."""
    calls = iter(range(10**9))
    return lambda: 1.7e9 + 86400.0 * (-1) ** (n := next(calls)) * n


def test_a_clock_that_jumps_changes_nothing(tmp_path, whole, monkeypatch):
    monkeypatch.setattr(time, "time", jumping())
    make_run(RUN, tmp_path / "run")
    same(tmp_path / "run", whole)
    folder = cut(tmp_path / "run", tmp_path / "cut", 9)
    for file in folder.iterdir():
        os.utime(file, (4e9, 4e9))  # of the year 2096
    assert ended(resume(folder))
    same(folder, whole)
    assert replay([str(folder)]) == 0


@pytest.mark.parametrize("key", sorted(RUN.values))
def test_a_configuration_that_lacks_a_group_is_one_line(key, tmp_path, whole):
    folder = cut(whole, tmp_path / "run", 12)
    cfg = OmegaConf.load(folder / "config.yaml")
    del cfg[key]
    OmegaConf.save(cfg, folder / "config.yaml")
    refused_in_one_line(folder, rf"config\.yaml: {key}: missing or unknown; of another version, or no run's")


@pytest.mark.parametrize("more", ["tool:\n  width: 3\n", "tool: 3\n"])
def test_settings_that_this_version_does_not_know_are_named(more, tmp_path, whole):
    """They would be without effect, and nobody could tell which run this is."""
    folder = cut(whole, tmp_path / "run", 12)
    with (folder / "config.yaml").open("a") as file:
        file.write(more)
    refused_in_one_line(folder, r"config\.yaml: tool: missing or unknown; of another version, or no run's")


def refused_in_one_line(folder: Path, line: str) -> None:
    """A run that can neither be continued nor replayed, and that stays as it is."""
    before = {file: file.read_bytes() for file in folder.iterdir() if file.is_file()}
    for attempt in (lambda: resume(folder), lambda: replay([str(folder)])):
        with pytest.raises(UserError, match=line) as caught:
            attempt()
        assert "\n" not in str(caught.value)
    assert {file: file.read_bytes() for file in folder.iterdir() if file.is_file()} == before
