"""Sweeps: the same command again makes what is missing, and nothing twice."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hydra.plugins.sweeper import Sweeper

from deformpush.cli import status
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.run import make_run
from deformpush.experiment.setup import read
from deformpush.experiment.sweep import manifest
from deformpush.experiment.sweep.hydra_callback import compose_kinds_only
from deformpush.experiment.sweep.names import LONGEST, short, sweep_name, with_folder
from deformpush.experiment.sweep.run_or_resume import FailedBeforeError, run_or_resume
from deformpush.experiment.sweep.status import look
from deformpush.record.files import write_whole
from deformpush.record.folder import RunFolder
from deformpush.record.lock import Lock
from deformpush.record.status import run_status
from tests.experiment.test_resume import cut

ROOT = Path(__file__).resolve().parents[2]
TOY = ["world=toy", "robot=tool", "record=off", "optimizer=random"]
CFG = compose([*TOY, "max_pushes=5"])
RUN = read(CFG)


def sweep(folder, *settings, **environment) -> subprocess.CompletedProcess[str]:
    """Make a sweep as a user does, in an empty folder."""
    command = [sys.executable, "-m", "deformpush", "-m", *TOY, *settings]
    surroundings = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=surroundings, check=False)


def times(folder: Path) -> dict[str, int]:
    return {str(f): f.stat().st_mtime_ns for f in folder.rglob("summary.json")}


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "sweep.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A sweep of four runs, made in two processes."""
    home = tmp_path_factory.mktemp("home")
    done = sweep(home, "max_pushes=5", "seed=0,1", "acq.w=1,2", "hydra/launcher=processes")
    assert (done.returncode, done.stderr) == (0, "")
    (folder,) = (home / "runs" / "sweeps").iterdir()
    return home, folder


@pytest.fixture
def run(tmp_path):
    make_run(RUN, tmp_path / "run")
    return tmp_path / "run"


def test_a_sweep_is_named_by_its_overrides(made):
    _, folder = made
    assert folder.name == "acq.w=1+2_max_pushes=5_optimizer=random_record=off_robot=tool_seed=0+1_world=toy"
    listed = {job.name for job in manifest.read(folder)}
    assert listed == {item.name for item in folder.iterdir() if item.is_dir()}
    assert len(listed) == 4
    assert {name.partition(",")[0] for name in listed} == {"acq.w=1", "acq.w=2"}


def test_the_same_command_again_leaves_finished_runs_alone_and_makes_the_others(made):
    home, folder = made
    before = times(folder)
    kept, lost = sorted(folder.glob("acq*"))[:2]
    cut_short = cut(kept, home / "cut", 2)
    shutil.rmtree(kept)
    cut_short.rename(kept)
    shutil.rmtree(lost)
    done = sweep(home, "acq.w=1,2", "seed=0,1", "max_pushes=5")
    assert done.returncode == 0
    assert "4 runs\n  done  " in done.stdout
    after = times(folder)
    changed = {path for path in after if after[path] != before[path]}
    assert changed == {str(kept / "summary.json"), str(lost / "summary.json")}
    assert json.loads((kept / "summary.json").read_text())["resumed"] == 2
    assert json.loads((lost / "summary.json").read_text())["resumed"] is None


def test_sweep_csv_tells_of_every_run(made):
    _, folder = made
    (folder / "sweep.csv").unlink()
    assert status.main([str(folder)]) == 0
    rows = table(folder)
    assert {(row["seed"], row["acq.w"], row["state"], row["pushes"]) for row in rows} == {
        (seed, w, "done", "5") for seed in "01" for w in "12"
    }
    for row in rows:
        end = json.loads((folder / row["run"] / "summary.json").read_text())
        assert float(row["e_T"]) == end["e_T"]


def test_a_bad_combination_is_refused_with_its_reason_and_the_others_are_made(tmp_path):
    done = sweep(tmp_path, "max_pushes=3", "bounds.kappa=[0,1],[1,0]", "hydra.sweep.dir=here")
    assert done.returncode == 2
    states = {row["run"].partition(",")[0]: (row["state"], row["reason"]) for row in table(tmp_path / "here")}
    assert states["bounds.kappa=[0"][0] in ("done", "refused")
    assert sorted(row["state"] for row in table(tmp_path / "here")) == ["done", "refused"]
    reason = next(row["reason"] for row in table(tmp_path / "here") if row["state"] == "refused")
    assert reason.startswith("bounds.kappa")
    assert reason in done.stderr


def test_a_worker_that_dies_costs_no_push(tmp_path):
    """The sweep goes on, and continues what the worker had begun."""
    settings = [
        "max_pushes=60",
        "seed=0,1,2",
        "stop=strict",
        "hydra/launcher=processes",
        "hydra.launcher.n_jobs=2",
    ]
    command = [sys.executable, "-m", "deformpush", "-m", *TOY, *settings, "hydra.sweep.dir=here"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    going = subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    killed = False
    for _ in range(6000):
        begun = [f for f in (tmp_path / "here").glob("*/pushes.csv") if f.read_bytes().count(b"\n") > 3]
        if begun and (worker := _worker(going.pid)):
            os.kill(worker, signal.SIGKILL)
            killed = True
            break
        time.sleep(0.01)
    out, err = going.communicate(timeout=120)
    assert killed
    assert going.returncode == 0, err
    assert "a worker process died" in err
    assert "Traceback" not in err
    assert "3 runs\n  done        3  3 spent the budget\n" in out
    for folder in (tmp_path / "here").glob("*seed*"):
        assert run_status(RunFolder(folder)).state == "done"


def _worker(parent: int) -> int | None:
    """A process of the launcher's pool: a child of `parent` that runs loky's worker."""
    for item in Path("/proc").glob("[0-9]*"):
        try:
            stat = (item / "stat").read_text().rpartition(")")[2].split()
            command = (item / "cmdline").read_bytes()
            if int(stat[1]) == parent and b"loky" in command and b"resource_tracker" not in command:
                return int(item.name)
        except (OSError, ValueError):
            continue
    return None


@pytest.mark.parametrize("writes", [0, 1])
def test_a_run_killed_as_it_took_its_folder_is_made(writes, tmp_path, monkeypatch):
    class KilledError(BaseException):
        pass

    left = [True] * writes

    def dies(path, data, sync=True):
        if not left:
            raise KilledError
        left.pop()
        write_whole(path, data, sync)

    folder = RunFolder.create(tmp_path, RUN.yaml)
    with monkeypatch.context() as patch:
        patch.setattr("deformpush.record.folder.write_whole", dies)
        with pytest.raises(KilledError):
            folder.claim()
    assert run_or_resume(CFG, tmp_path, retry=False).status == "budget"
    assert run_status(folder).state == "done"
    assert (tmp_path / "provenance.json").exists()


def test_a_run_that_another_process_makes_is_left_to_it(run, capsys):
    (run / "summary.json").unlink()
    lock = Lock.take(run)
    before = (run / "pushes.csv").read_bytes()
    assert run_or_resume(CFG, run, retry=False) is None
    lock.release()
    assert (run / "pushes.csv").read_bytes() == before


def test_other_settings_in_the_same_folder_are_refused(run):
    other = compose([*TOY, "max_pushes=5", "task.weights.k_c=4.5"])
    with pytest.raises(
        UserError, match=r"holds a run of other settings \(task.weights.k_c was 3.0, is 4.5\)"
    ):
        run_or_resume(other, run, retry=True)
    assert run_or_resume(compose([*TOY, "max_pushes=5", "record.image_px=64"]), run, retry=False) is None


def test_a_failed_run_is_made_once_more_only_on_request(run):
    summary = run / "summary.json"
    failed = summary.read_text().replace('"budget"', '"failed"')
    summary.write_text(failed)
    with pytest.raises(
        FailedBeforeError, match=r"^run: failed before \(.*\); sweep.retry=true makes"
    ) as caught:
        run_or_resume(CFG, run, retry=False)
    assert caught.value.exit_code == 1
    assert summary.read_text() == failed
    assert run_or_resume(CFG, run, retry=True).status == "budget"
    assert json.loads(summary.read_text())["status"] == "budget"
    assert (run / ".failed-1" / "summary.json").read_text() == failed
    assert (run / ".failed-1" / "pushes.csv").exists()


def test_what_status_says(tmp_path, capsys):
    for name in ("done", "killed", "failed", "busy"):
        make_run(RUN, tmp_path / "s" / name)
    (tmp_path / "s" / "killed" / "summary.json").unlink()
    (tmp_path / "s" / "busy" / "summary.json").unlink()
    end = tmp_path / "s" / "failed" / "summary.json"
    end.write_text(json.dumps({**json.loads(end.read_text()), "status": "failed", "reason": "it exploded"}))
    (tmp_path / "s" / "no").mkdir()
    (tmp_path / "s" / "no" / "refused.txt").write_text("object.d: too long\n")
    jobs = [
        manifest.Job(name, [f"seed={i}"])
        for i, name in enumerate(("done", "killed", "failed", "busy", "no", "new"))
    ]
    manifest.write(tmp_path / "s", jobs)
    lock = Lock.take(tmp_path / "s" / "busy")
    capsys.readouterr()
    assert status.main([str(tmp_path / "s")]) == 0
    lock.release()
    out = capsys.readouterr().out.splitlines()
    assert out[0].endswith("s: 6 runs")
    assert out[1:7] == [
        "  done        1  1 spent the budget",
        "  running     1  pushes so far: 5",
        "  interrupted 1  the same command again continues them",
        "  failed      1  sweep.retry=true makes them once more",
        "  refused     1",
        "  pending     1  not begun",
    ]
    assert out[7].startswith("  time left   about ")
    assert out[8:11] == [
        "interrupted: killed: no summary.json: it was killed",
        "failed: failed: it exploded",
        "refused: no: object.d: too long",
    ]
    assert [row["state"] for row in table(tmp_path / "s")] == [
        "done", "interrupted", "failed", "running", "refused", "pending",
    ]  # fmt: skip


@pytest.mark.parametrize("harm", [b"", b"{", b"[]", b'{"status": 3}', b"\xff\xfe"])
def test_a_damaged_summary_is_an_interrupted_run(harm, run):
    (run / "summary.json").write_bytes(harm)
    now = run_status(RunFolder(run))
    assert (now.state, now.pushes) == ("interrupted", 5)
    assert run_or_resume(CFG, run, retry=False).status == "budget"
    assert run_status(RunFolder(run)).state == "done"


@pytest.mark.parametrize("harm", [b"", b"{}", b'{"jobs": 3}', b'{"jobs": [{"name": 1}]}', b"\x00"])
def test_a_damaged_sweep_json_leaves_what_the_folders_tell(harm, run):
    (run.parent / "sweep.json").write_bytes(harm)
    assert [entry.job.name for entry in look(run.parent).entries] == ["run"]


def test_before_the_first_run_one_of_every_kind_is_composed(monkeypatch):
    composed = []
    monkeypatch.setattr(Sweeper, "validate_batch_is_legal", lambda _, batch: composed.extend(batch))
    compose_kinds_only()
    compose_kinds_only()  # a second sweep in this process: nothing piles up
    batch = [[f"object={name}", f"seed={n}", f"acq.w={n}e-1"] for name in ("rect", "meat") for n in range(9)]
    Sweeper.validate_batch_is_legal(None, batch)
    assert composed == [["object=rect", "seed=8", "acq.w=8e-1"], ["object=meat", "seed=8", "acq.w=8e-1"]]


def test_names_are_short_safe_and_the_same_for_the_same_settings():
    assert sweep_name(["seed=0,1", "acq.w=1"]) == sweep_name(["acq.w=1", "seed=0,1"]) == "acq.w=1_seed=0+1"
    long = [",".join(f"key{i}=value" for i in range(n)) for n in (40, 41)]
    names = {short(text) for text in long}
    assert len(names) == 2
    assert max(map(len, names)) <= LONGEST
    for text in ("../../etc", "a/b", "a b'c\"", "", "..", "seed=é"):
        assert "/" not in short(text)
        assert short(text) not in ("", ".", "..")


def test_only_sweeps_without_a_folder_get_one():
    assert with_folder(["seed=1"]) == ["seed=1"]
    own = ["-m", "seed=1,2", "hydra.sweep.dir=mine"]
    assert with_folder(own) == own
    given = ["--multirun", "seed=1,2", "hydra/launcher=processes", "sweep.retry=true"]
    assert with_folder(given) == [*given, "hydra.sweep.dir='runs/sweeps/seed=1+2'"]


def test_status_of_what_is_not_there(tmp_path):
    with pytest.raises(UserError, match="nowhere: no such folder"):
        status.main(["nowhere"])
    with pytest.raises(UserError, match="holds no runs"):
        status.main([str(tmp_path)])
