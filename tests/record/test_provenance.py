"""Provenance tells a clean checkout from a changed one and from none."""

import shlex
import subprocess
import sys

from deformpush.record.provenance import checkout, provenance


def git(root, *arguments):
    identity = ["-c", "user.name=a", "-c", "user.email=a@b"]
    command = ["git", "-C", str(root), *identity, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True)


def test_checkout_reports_commit_and_changes(tmp_path):
    git(tmp_path, "init")
    (tmp_path / "a").write_text("1")
    git(tmp_path, "add", "a")
    git(tmp_path, "commit", "-m", "x")
    commit = git(tmp_path, "rev-parse", "HEAD").stdout.strip()
    assert checkout(tmp_path) == {"commit": commit, "dirty": False, "changed": []}
    (tmp_path / "a").write_text("2")
    assert checkout(tmp_path) == {"commit": commit, "dirty": True, "changed": ["a"]}


def test_a_folder_below_another_repository_is_no_checkout(tmp_path):
    git(tmp_path, "init")
    (tmp_path / "site-packages").mkdir()
    assert checkout(tmp_path / "site-packages") is None


def test_provenance_names_this_process():
    found = provenance()
    assert found["python"] == ".".join(map(str, sys.version_info[:3]))
    assert shlex.split(found["command"])[1:] == sys.orig_argv[1:]
    assert found["cpus"] >= 1
