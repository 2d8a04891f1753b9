"""The names of the kernels that a run was computed with."""

import json
import subprocess
import sys

from deformpush.record.kernels import kernels
from tests.same_seed import ROOT, environment

CODE = "import json, numpy; from deformpush.record.kernels import kernels; print(json.dumps(kernels()))"


def kernels_under(setting: str) -> dict:
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        env=environment(setting),
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def test_the_kernels_of_this_process_have_names():
    found = kernels()
    assert found["blas"]
    assert all(one["kernel"] and one["version"] for one in found["blas"])
    json.dumps(found)


def test_another_setting_is_another_kernel():
    """Otherwise the comparisons of test_same_seed would compare a thing with itself."""
    assert {one["kernel"] for one in kernels_under("Nehalem")["blas"]} == {"Nehalem"}
    plain = kernels_under("all plain")
    assert {one["kernel"] for one in plain["blas"]} <= {"Katmai", "Prescott"}
    assert plain["numpy"] == []
    assert {one["threads"] for one in kernels_under("two threads")["blas"]} <= {1, 2}
