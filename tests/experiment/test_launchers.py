"""Launchers: one line for what is missing, patience with jobs that die, one core for each run."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

from deformpush.errors import Stopped
from deformpush.experiment.console import Verbosity
from deformpush.record.folder import RunFolder
from deformpush.record.status import run_status
from tests.cli.test_cli import cli  # noqa: F401 (a fixture)
from tests.experiment.test_sweep import ROOT, TOY, sweep, table
from tests.setups import setup

PROBE = """
import json, os
from deformpush.optimizer.rivals.random_push import RandomPush

class Probing(RandomPush):
    def __init__(self, parts):
        super().__init__(parts)

    def _choose(self, state):
        import cv2, torch
        from threadpoolctl import threadpool_info
        pools = [pool["num_threads"] for pool in threadpool_info()]
        with open("threads.txt", "a") as file:
            file.write(json.dumps([torch.get_num_threads(), cv2.getNumThreads(), *pools]) + "\\n")
        return super()._choose(state)
"""


@pytest.fixture
def probing(tmp_path):
    """An optimizer of the user's own that writes down how many threads libraries would use."""
    (tmp_path / "mine" / "optimizer").mkdir(parents=True)
    (tmp_path / "mine" / "optimizer" / "probing.yaml").write_text("_target_: probing.Probing\n")
    (tmp_path / "mine" / "probing.py").write_text(PROBE)
    return tmp_path


@pytest.mark.parametrize("launcher", ["basic", "processes", "slurm_local"])
def test_runs_use_one_thread_each(launcher, probing):
    pytest.importorskip("threadpoolctl")
    settings = [
        "--config-dir",
        "mine",
        *TOY[:3],
        "optimizer=probing",
        "max_pushes=2",
        f"hydra/launcher={launcher}",
    ]
    command = [sys.executable, "-m", "deformpush", "-m", *settings, "seed=0,1", "hydra.sweep.dir=here"]
    freely = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=probing,
        env={**freely, "PYTHONPATH": str(ROOT)},
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert [row["state"] for row in table(probing / "here")] == ["done", "done"]
    told = [json.loads(line) for line in (probing / "threads.txt").read_text().splitlines()]
    assert len(told) == 4
    assert {number for line in told for number in line} == {1}


def test_a_job_that_dies_is_told_of_and_the_others_are_waited_for(tmp_path):
    settings = [
        "max_pushes=60",
        "stop=strict",
        "seed=0,1",
        "hydra/launcher=slurm_local",
        "hydra.sweep.dir=here",
    ]
    command = [sys.executable, "-m", "deformpush", "-m", *TOY, *settings]
    going = subprocess.Popen(
        command,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    victim = None
    for _ in range(12000):
        if any(f.read_bytes().count(b"\n") > 3 for f in (tmp_path / "here").glob("*seed=0*/pushes.csv")):
            victim = _at_work_in(next((tmp_path / "here").glob("*seed=0*")))
            os.kill(victim, signal.SIGKILL)
            break
        time.sleep(0.01)
    _, err = going.communicate(timeout=240)
    assert victim is not None
    assert going.returncode == 1, err
    assert err.startswith("job ")
    assert "ended without a result" in err
    assert err.count("\n") == 1
    assert {row["seed"]: row["state"] for row in table(tmp_path / "here")} == {
        "0": "interrupted",
        "1": "done",
    }
    again = sweep(tmp_path, *settings)
    assert again.returncode == 0
    assert {row["seed"]: row["state"] for row in table(tmp_path / "here")} == {"0": "done", "1": "done"}


def _at_work_in(folder: Path) -> int:
    """The process that holds a run folder's lock."""
    for item in Path("/proc").glob("[0-9]*/fd"):
        try:
            if any(os.readlink(link) == str(folder / ".lock") for link in item.iterdir()):
                return int(item.parent.name)
        except OSError:
            continue
    raise AssertionError("no one works there")


@pytest.mark.skipif(find_spec("ray") is not None, reason="Ray is installed")
def test_a_launcher_that_is_not_installed_is_one_line(cli, tmp_path):  # noqa: F811
    answer = cli("-m", *TOY, "seed=0,1", "hydra/launcher=ray", "hydra.sweep.dir=here")
    assert answer.err == "hydra/launcher=ray: needs pip install 'deformpush[ray]'\n"
    assert (answer.code, answer.out) == (2, "")
    assert not (tmp_path / "here").exists()


def test_the_plugins_of_the_extra_sweep_are_named_too(monkeypatch):
    from hydra.errors import MissingConfigException

    from deformpush.config.compose import explain

    for choice, plugin in {"processes": "joblib", "slurm": "submitit_slurm"}.items():
        error = MissingConfigException("no", missing_cfg_file=f"hydra/launcher/{plugin}")
        line = explain(error, ["-m", f"hydra/launcher={choice}"])
        assert line == f"hydra/launcher={choice}: needs pip install 'deformpush[sweep]'"


@pytest.mark.skipif(shutil.which("srun") is not None, reason="SLURM is here")
def test_slurm_where_there_is_none_is_one_line(cli):  # noqa: F811
    answer = cli("-m", *TOY, "seed=0,1", "hydra/launcher=slurm", "hydra.sweep.dir=here")
    assert answer.err.startswith("hydra/launcher=slurm: no srun here; ")
    assert (answer.code, answer.err.count("\n")) == (2, 1)


def test_a_sweep_folder_that_cannot_be_used_is_one_line(cli, tmp_path):  # noqa: F811
    (tmp_path / "file").touch()
    answer = cli("-m", *TOY, "seed=0,1", "hydra.sweep.dir=file/x")
    assert answer.err == "hydra.sweep.dir = file/x: cannot be used for a sweep: Not a directory\n"
    assert answer.code == 2


def test_the_end_of_a_jobs_time_ends_the_run_first_and_then_asks_the_launcher(tmp_path, monkeypatch):
    """Submitit hears SIGUSR2 and queues the job again or gives up; by then the run must be resumable."""
    from deformpush.experiment.run import make_run
    from deformpush.worlds.toy import ToyWorld

    seen, whole = [], ToyWorld.push

    def push(self, path):
        if len(list(seen)) == 0 and (tmp_path / "run" / "pushes.csv").read_bytes().count(b"\n") == 4:
            os.kill(os.getpid(), signal.SIGUSR2)
        return whole(self, path)

    def requeue(number, frame):
        seen.append((number, run_status(RunFolder(tmp_path / "run")).state))
        raise SystemExit(-1)

    monkeypatch.setattr(ToyWorld, "push", push)
    before = signal.signal(signal.SIGUSR2, requeue)
    try:
        with pytest.raises(SystemExit):
            make_run(setup(*TOY, "max_pushes=8"), tmp_path / "run", Verbosity.BAR_ONLY)
    finally:
        assert signal.signal(signal.SIGUSR2, before) is requeue
    assert seen == [(signal.SIGUSR2, "interrupted")]
    end = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert (end["status"], end["reason"], end["pushes"]) == (
        "interrupted",
        "stopped from outside (SIGUSR2)",
        2,
    )
    assert issubclass(Stopped, KeyboardInterrupt)
