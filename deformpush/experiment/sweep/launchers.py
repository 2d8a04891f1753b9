"""What Hydra's launchers lack: a line that says what to install, and patience with jobs that die."""

import shutil
import subprocess
import sys
import time
from importlib.util import find_spec
from typing import Any

from deformpush.errors import UserError
from deformpush.extras import needed_extra, not_installed

ASK_EVERY_S = 3.0
SHARED_FOLDERS_S = 15.0
"""Until a file that another machine wrote shows up."""


def check_installed(choice: str, target: str) -> None:
    """Make sure that the plugin of the chosen launcher is there.

    Args:
        choice: option of hydra/launcher.
        target: full name of its class.

    Raises:
        UserError: it is not, or it needs SLURM and there is none.
    """
    package = ".".join(target.split(".")[:2])
    extra = needed_extra(package)
    try:
        missing = find_spec(package) is None
    except ModuleNotFoundError:
        missing = True
    if missing and extra:
        raise UserError(not_installed(choice, extra))
    if target.endswith("SlurmLauncher") and shutil.which("srun") is None:
        raise UserError(
            f"hydra/launcher={choice}: no srun here; on a machine without SLURM, slurm_local does alike"
        )


def wait_for_all(target: str) -> None:
    """Let a sweep wait for its other jobs when one dies, instead of ending with a traceback.

    The plugins ask one job after the other for its result, and the first that has none (killed, out of time,
    out of memory) raises; with Ray all others are stopped then. What became of a run stands in its folder,
    which is looked at in the end.
    """
    if "submitit" in target:
        _patient_submitit()
    elif target.endswith("RayLauncher"):
        _patient_ray()


def _patient_submitit() -> None:
    from submitit import Job, SlurmJob
    from submitit.core.utils import FailedJobError, UncompletedJobError

    def results(job: Any) -> list[Any]:
        try:
            if isinstance(job, SlurmJob):
                _wait_in_queue(job)
            found = whole(job)
        except FailedJobError as error:
            lines = [line.strip() for line in str(error).splitlines()]
            why = f"could not be carried out: {[line for line in lines if 'Error' in line][-1]}"
        except UncompletedJobError:
            why = "ended without a result: killed, or out of time or memory"
        else:
            if not isinstance(getattr(found[0], "_return_value", None), UncompletedJobError):
                return list(found)
            why = "ended because its time was up"
        return [_lost(f"job {job.job_id} {why} ({job.paths.stderr})")]

    whole = getattr(Job.results, "whole", Job.results)
    results.whole = whole  # type: ignore[attr-defined]
    Job.results = results  # type: ignore[method-assign, assignment]


def _patient_ray() -> None:
    import ray
    from hydra_plugins.hydra_ray_launcher import _core

    class Patient:
        """All that the plugin's launch asks of Ray."""

        @staticmethod
        def get(job: Any) -> Any:
            try:
                return ray.get(job)
            except ray.exceptions.RayError as error:
                return _lost(f"a job could not be carried out: {str(error).strip().splitlines()[-1]}")

    _core.ray = Patient


def _lost(why: str) -> Any:
    """Say why a job has no result; what stands for it."""
    from hydra.core.utils import JobReturn, JobStatus

    print(why, file=sys.stderr, flush=True)
    return JobReturn(status=JobStatus.COMPLETED)


def _wait_in_queue(job: Any) -> None:
    """Wait for a job of SLURM until its result is there.

    Submitit asks the accounting, without which a job that was killed seems to go on for ever.

    Raises:
        UncompletedJobError: the job has left the queue without a result.
    """
    from submitit.core.utils import UncompletedJobError

    left = SHARED_FOLDERS_S
    while not job.paths.result_pickle.exists():
        if left <= 0:
            raise UncompletedJobError
        time.sleep(ASK_EVERY_S)
        queue = subprocess.run(
            ["squeue", "-h", "-r", "-o", "%i"], capture_output=True, text=True, check=False
        )
        # No answer says nothing about the job.
        left = (
            SHARED_FOLDERS_S if queue.returncode or job.job_id in queue.stdout.split() else left - ASK_EVERY_S
        )
