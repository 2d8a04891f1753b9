"""A term added to `task.TERMS` needs no other edit to be shown."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_a_fourth_term_shows_up_by_itself(tmp_path):
    command = [sys.executable, "-m", "tests.study.fourth_term", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
