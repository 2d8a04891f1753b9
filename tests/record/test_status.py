"""A folder alone tells how far its run is."""

import json
import re

import pytest

from deformpush.record.folder import RunFolder
from deformpush.record.lock import Lock
from deformpush.record.status import STATES, run_status


def ended(folder: RunFolder, **told) -> None:
    folder.write_json("summary.json", {"status": "reached", "reason": "all", "pushes": 4, **told})


@pytest.fixture
def folder(tmp_path):
    return RunFolder(tmp_path)


@pytest.mark.parametrize(
    ("status", "state", "text"),
    [
        ("reached", "done", "reached after 4 pushes"),
        ("budget", "done", "budget after 4 pushes"),
        ("damaged", "done", "damaged after 4 pushes"),
        ("failed", "failed", "all"),
        ("interrupted", "interrupted", "all"),
    ],
)
def test_a_run_that_ended_says_how(folder, status, state, text):
    ended(folder, status=status)
    now = run_status(folder)
    assert (now.state, now.text, now.pushes) == (state, text, 4)
    assert now.summary["status"] == status


def test_one_push_is_one_push(folder):
    ended(folder, pushes=1)
    assert run_status(folder).text == "reached after 1 push"


def test_a_folder_that_is_held_is_running(folder):
    folder.table.write_text("header\nrow 0\nrow 1\nrow 2\n")
    lock = Lock.take(folder.path)
    now = run_status(folder)
    lock.release()
    assert (now.state, now.pushes) == ("running", 2)


def test_a_run_without_its_end_was_killed(folder):
    folder.table.write_text("header\nrow 0\nrow 1\n")
    now = run_status(folder)
    assert (now.state, now.text, now.pushes) == ("interrupted", "no summary.json: it was killed", 1)


@pytest.mark.parametrize("content", ["{", "[]", "3", json.dumps({"status": "reached"})])
def test_a_damaged_summary_counts_as_interrupted(folder, content):
    folder.summary.write_text(content)
    now = run_status(folder)
    assert now.state == "interrupted"
    assert re.fullmatch(r"summary\.json is damaged: (not JSON|no keys in it|no reason)", now.text)


def test_a_run_that_never_began(folder):
    assert run_status(folder).state == "pending"
    (folder.path / "refused.txt").write_text("object.E: must be positive\n")
    now = run_status(folder)
    assert (now.state, now.text) == ("refused", "object.E: must be positive")
    assert {"pending", "refused"} < set(STATES)
