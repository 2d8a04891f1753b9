"""Runs are found where they lie; what cannot be compared is left out by name, with the reason."""

import json
import shutil

import pytest
import yaml

from deformpush.errors import UserError
from deformpush.record.saved_config import read_settings
from deformpush.record.table import COLUMNS
from deformpush.study.find_runs import find_runs
from tests.study.folders import finished


def test_runs_of_a_sweep_come_in_the_order_of_their_numbers(tmp_path):
    for seed in (10, 9, 0):
        finished(tmp_path / "deep" / f"seed={seed}", 1, seed=seed)
    found = find_runs([tmp_path])
    assert [run.name for run in found.runs] == ["seed=0", "seed=9", "seed=10"]
    assert found.skipped == []


def test_a_run_named_twice_counts_once(sweep):
    assert len(find_runs([sweep, sweep / "acq.w=1,seed=0", str(sweep)]).runs) == 4


def test_a_run_is_read_as_it_ended(sweep):
    run = find_runs([sweep]).runs[1]
    assert (run.name, run.summary.status, run.summary.pushes) == ("acq.w=1,seed=1", "budget", 15)
    assert (run.settings["acq.w"], run.options["object"]) == (1.0, "rect")
    assert len(run.pushes) == 16


def test_a_run_of_a_version_without_strain_is_read(sweep, tmp_path):
    folder = shutil.copytree(sweep / "acq.w=1,seed=1", tmp_path / "old")
    new = ("strain_limit", "strain_peak", "exceedances", "strain_dose")
    told = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps({k: v for k, v in told.items() if k not in new}))
    lines = [line.split(",") for line in (folder / "pushes.csv").read_text().splitlines()]
    kept = COLUMNS.index("strain_p99_peak")
    (folder / "pushes.csv").write_text("".join(f"{','.join(line[:kept])}\n" for line in lines))
    found = find_runs([folder])
    assert found.skipped == []
    assert found.runs[0].summary.strain_peak is None
    assert found.runs[0].pushes["strain_p99_peak"].isna().all()


def cut(path):
    path.write_bytes(path.read_bytes()[:-200])


def another_version(path):
    path.write_text(json.dumps(json.loads(path.read_text()) | {"mood": 1}))


@pytest.mark.parametrize(
    ("name", "damage", "reason"),
    [
        ("summary.json", lambda path: path.unlink(), "no summary.json: it still runs, or was killed"),
        ("summary.json", cut, "summary.json is damaged: not JSON"),
        ("summary.json", another_version, "summary.json is of another version (differs in mood)"),
        ("pushes.csv", lambda path: path.unlink(), "no pushes.csv"),
        (
            "pushes.csv",
            lambda path: path.write_text("k,e\n0,1\n"),
            "pushes.csv is damaged or of another version",
        ),
        ("pushes.csv", cut, "pushes.csv has 3 of 4 pushes"),
        ("config.yaml", lambda path: path.unlink(), "no config.yaml"),
        (
            "config.yaml",
            lambda path: path.write_text("a: [1"),
            "config.yaml is damaged (line 2: did not find expected ',' or ']')",
        ),
        (
            "config.yaml",
            lambda path: path.write_text("hello"),
            "config.yaml is damaged (no mapping of settings)",
        ),
        (".", shutil.rmtree, "no such folder"),
    ],
)
def test_what_cannot_be_read_is_left_out_with_the_reason(sweep, tmp_path, name, damage, reason):
    good = shutil.copytree(sweep / "acq.w=1,seed=0", tmp_path / "good")
    bad = shutil.copytree(sweep / "acq.w=2,seed=0", tmp_path / "bad")
    damage(bad / name)
    found = find_runs([good, bad])
    assert [run.name for run in found.runs] == ["good"]
    assert found.skipped == [("bad", reason)]


def test_nothing_to_compare_is_the_users_error(tmp_path):
    with pytest.raises(UserError, match=r"^no finished run among .*nowhere \(nowhere: no such folder\)$"):
        find_runs([tmp_path / "nowhere"])
    with pytest.raises(UserError, match="no finished run among"):
        find_runs([tmp_path])


@pytest.mark.parametrize(
    "text",
    [
        "a:\n- 1\n- b: 2\nc: {d: 3}\n",
        "# said before\na: 1\n\n# and between\nb: 'x\n\n  y'\n",
        "a: |\n  x\n\n  y\nb: 2\nc: 3",
        "{a: 1,\nb: 2}",
        "  a: 1\n  b: 2\n",
    ],
)
def test_settings_are_read_as_yaml_reads_them(text):
    """Also where the text cannot be taken apart, as a file that a person has edited."""
    assert read_settings(text) == yaml.safe_load(text)


def test_settings_of_one_run_are_not_those_of_another(sweep):
    runs = find_runs([sweep]).runs
    assert [run.settings["acq.w"] for run in runs] == [1.0, 1.0, 2.0, 2.0]
    assert [run.settings["seed"] for run in runs] == [0, 1, 0, 1]
