"""Provenance tells a clean checkout from a changed one and from none."""

import json
import shlex
import subprocess
import sys

import pytest

from deformpush.record.folder import RunFolder
from deformpush.record.kernels import kernels
from deformpush.record.provenance import checkout, provenance, read_provenance


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


def test_what_was_written_is_read_and_what_another_version_added_is_kept(tmp_path):
    folder = RunFolder(tmp_path)
    folder.write_json("provenance.json", {**provenance(), "colour": ["red"], "resumed": [{"after": 3}]})
    found = read_provenance(tmp_path / "provenance.json")
    assert (found["colour"], found["resumed"]) == (["red"], [{"after": 3}])
    assert found["packages"] == provenance()["packages"]


def test_kernels_of_libraries_that_came_later_are_added_to_the_part_they_belong_to(tmp_path, monkeypatch):
    folder = RunFolder.create(tmp_path, "seed: 0\n")
    folder.claim().release()
    first = read_provenance(tmp_path / "provenance.json")
    assert first["kernels"] == kernels()
    later = {**kernels(), "torch": "AVX2"}
    monkeypatch.setattr("deformpush.record.folder.kernels", lambda: later)
    folder.note_kernels()
    assert read_provenance(tmp_path / "provenance.json") == {**first, "kernels": later}
    folder.note_resumption(3)
    monkeypatch.setattr("deformpush.record.folder.kernels", lambda: {**later, "torch": "AVX512"})
    folder.note_kernels()
    found = read_provenance(tmp_path / "provenance.json")
    assert (found["kernels"]["torch"], found["resumed"][0]["kernels"]["torch"]) == ("AVX2", "AVX512")


@pytest.mark.parametrize(
    ("key", "value", "where"),
    [
        ("git", "abc", "git"),
        ("git", {"commit": ["a"], "dirty": False, "changed": []}, r"git\.commit"),
        ("git", {"commit": "a", "dirty": "no", "changed": []}, r"git\.dirty"),
        ("git", {"commit": "a"}, r"git\.dirty"),
        ("packages", [1], "packages"),
        ("packages", {"numpy": 2}, r"packages\.numpy"),
        ("cpus", "many", "cpus"),
        ("time", 3, "time"),
        ("kernels", 3, "kernels"),
        ("kernels", {"blas": [{"library": 3}], "numpy": []}, r"kernels\.blas\.0\.library"),
        ("kernels", {"blas": [], "numpy": "AVX2"}, r"kernels\.numpy"),
        ("kernels", {"blas": [], "numpy": [], "torch": 2}, r"kernels\.torch"),
        ("resumed", 3, "resumed"),
        ("resumed", [3], r"resumed\.0"),
        ("resumed", [{"after": "x"}], r"resumed\.0\.after"),
    ],
)
def test_a_value_of_the_wrong_type_is_one_line(key, value, where, tmp_path):
    folder = RunFolder.create(tmp_path, "seed: 0\n")
    folder.claim().release()
    found = json.loads((tmp_path / "provenance.json").read_text())
    (tmp_path / "provenance.json").write_text(json.dumps({**found, key: value}))
    with pytest.raises(ValueError, match=rf"^provenance\.json is damaged: {where} = ") as caught:
        read_provenance(tmp_path / "provenance.json")
    assert "\n" not in str(caught.value)
    folder.note_resumption(5)
    assert json.loads((tmp_path / "provenance.json").read_text())["resumed"][-1]["after"] == 5
