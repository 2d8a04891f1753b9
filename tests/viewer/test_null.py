"""The null twin stands in for a stream wherever the recorder uses one."""

import inspect
import subprocess
import sys

from deformpush.viewer.null import NullStream
from deformpush.viewer.stream import Stream


def public(kind: type) -> dict[str, list[str]]:
    methods = inspect.getmembers(kind, inspect.isfunction)
    return {name: list(inspect.signature(f).parameters) for name, f in methods if not name.startswith("_")}


def test_the_twins_offer_the_same():
    assert public(NullStream) == public(Stream)
    assert set(public(Stream)) == {"catch_up", "push", "close", "release"}


def test_the_null_twin_needs_no_rerun():
    code = "import sys, deformpush.experiment.recorder; print('rerun' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
