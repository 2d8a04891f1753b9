"""`import deformpush`: runs as from the command line, read back as frames; the examples of docs/api.md."""

import csv
import json
import re
import shutil
import subprocess
import sys
import threading
from datetime import datetime
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from hydra.core.global_hydra import GlobalHydra
from threadpoolctl import threadpool_info

import deformpush
from deformpush.config.groups import conf_dir
from deformpush.experiment import api
from deformpush.record.table import COLUMNS, TIMES
from deformpush.study import run_data
from deformpush.task import TERMS

ROOT = Path(__file__).resolve().parent.parent
TOY = ("world=toy", "robot=tool", "record=off")
SHORT = (*TOY, "optimizer=random", "max_pushes=3")


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> deformpush.Run:
    return deformpush.run(*SHORT, seed=3, folder=tmp_path_factory.mktemp("short"), progress=False)


@pytest.fixture(scope="module")
def sweep(tmp_path_factory) -> Path:
    """Two goals and two seeds; of the runs that another sweep.json lists, one was killed, one never begun."""
    folder = tmp_path_factory.mktemp("sweep")
    for turn in (10, 20):
        for seed in (0, 1):
            place = folder / f"turn={turn},seed={seed}"
            deformpush.run(*SHORT, f"task.goal.turn_deg={turn}", seed=seed, folder=place, progress=False)
    shutil.copytree(folder / "turn=10,seed=0", folder / "turn=30,seed=0")
    (folder / "turn=30,seed=0" / "summary.json").unlink()
    jobs = [{"name": name, "overrides": []} for name in ("turn=10,seed=0", "turn=40,seed=0")]
    (folder / "sweep.json").write_text(json.dumps({"jobs": jobs}), encoding="utf-8")
    return folder


def without_times(file: Path) -> list[list[str]]:
    with file.open(encoding="utf-8", newline="") as handle:
        rows = list(csv.reader(handle))
    kept = [i for i, name in enumerate(rows[0]) if name not in TIMES]
    return [[row[i] for i in kept] for row in rows]


def test_importing_takes_no_time():
    line = [sys.executable, "-X", "importtime", "-c", "import deformpush"]
    times = []
    for _ in range(3):
        told = subprocess.run(line, capture_output=True, text=True, check=True, cwd=ROOT).stderr
        times += [int(found) for found in re.findall(r"\| +(\d+) \| deformpush$", told, re.MULTILINE)]
    assert min(times) < 150_000


def test_importing_loads_no_library():
    code = (
        "import sys, deformpush; print({name.partition('.')[0] for name in sys.modules} & {'numpy', 'yaml'})"
    )
    line = [sys.executable, "-c", code]
    assert subprocess.run(line, capture_output=True, text=True, check=True, cwd=ROOT).stdout == "set()\n"


def test_every_name_is_there():
    for name in deformpush.__all__:
        assert getattr(deformpush, name).__doc__, name
    assert set(deformpush.__all__) <= set(dir(deformpush))
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        _ = deformpush.rnu


@pytest.mark.parametrize("optimizer", ["abo", "abo_motion"])
def test_a_run_writes_what_the_command_line_writes(optimizer, tmp_path):
    settings = [*TOY, f"optimizer={optimizer}", "max_pushes=12", "seed=5"]
    line = [sys.executable, "-m", "deformpush", *settings, f"hydra.run.dir={tmp_path / 'shell'}"]
    subprocess.run(line, check=True, cwd=ROOT, capture_output=True)
    made = deformpush.run(*settings, folder=tmp_path / "python", progress=False)
    there = {file.name for file in (tmp_path / "shell").iterdir()} - {"deformpush.log"}
    assert there == {file.name for file in made.folder.iterdir()}
    assert without_times(made.folder / "pushes.csv") == without_times(tmp_path / "shell" / "pushes.csv")
    for name in there & {"config.yaml", "contours.npz", "forecasts.csv"}:
        assert (made.folder / name).read_bytes() == (tmp_path / "shell" / name).read_bytes(), name


def test_a_run_tells_what_its_files_hold(short):
    assert list(short.pushes.columns) == COLUMNS
    assert len(short.pushes) == short.summary.pushes + 1 == 4
    with np.load(short.folder / "contours.npz") as file:
        assert np.array_equal(short.contours, file["contours"])
    assert short.config == yaml.safe_load((short.folder / "config.yaml").read_text(encoding="utf-8"))
    assert short.config["seed"] == short.summary.seed == 3
    assert short.config["options"]["world"] == "toy"
    assert short.name == short.folder.name


def test_what_a_run_tells_of_its_settings_is_a_copy(short):
    short.config["options"]["world"] = "changed"
    assert deformpush.load(short.folder).config["options"]["world"] == "toy"


def test_the_figure_is_that_of_the_run(short):
    figure = short.figure()
    moments = run_data.read(short.finished.folder).moments
    assert [axis.get_title() for axis in figure.axes][:4] == [f"k = {k}" for k in moments]
    assert any(axis.get_ylabel() == "error (-)" for axis in figure.axes)


def test_a_notebook_shows_how_it_ended(short):
    page = short._repr_html_()
    assert "budget after 3 pushes" in page
    assert str(short.folder) in page
    for term in TERMS:
        size = abs(short.pushes[term.column].iloc[-1]) * term.scale
        assert f"{term.name} ({term.unit})" in page
        assert f"{size:.{term.digits}f}" in page
        assert f"{short.finished.stop(term):.{term.digits}f}" in page
    assert page.count("<svg") == 1
    assert "budget after 3 pushes" in repr(short)
    assert TERMS[0].show(short.finished.error(TERMS[0])[-1]) in repr(short)


def test_a_notebook_shows_text_as_text(short, tmp_path):
    place = tmp_path / "<b>bold"
    shutil.copytree(short.folder, place)
    summary = json.loads((place / "summary.json").read_text(encoding="utf-8"))
    (place / "summary.json").write_text(json.dumps({**summary, "reason": "<script>", "object": "<i>"}))
    page = deformpush.load(place)._repr_html_()
    assert not {"<script", "<i>", "<b>bold"} & set(re.findall(r"<script|<i>|<b>bold", page))
    assert "&lt;script&gt;" in page


def test_a_run_without_pictures_is_shown_without(short, tmp_path):
    shutil.copytree(short.folder, tmp_path / "bare")
    (tmp_path / "bare" / "views.npz").write_bytes(b"no")
    page = deformpush.load(tmp_path / "bare")._repr_html_()
    assert "budget after 3 pushes" in page
    assert "<svg" not in page


def test_a_run_is_loaded_as_it_was_made(short):
    again = deformpush.load(short.folder)
    assert isinstance(again, deformpush.Run)
    pd.testing.assert_frame_equal(again.pushes, short.pushes)
    assert again.summary == short.summary


def test_a_sweep_is_one_frame(sweep):
    found = deformpush.load(sweep)
    assert isinstance(found, deformpush.Sweep)
    names = [f"turn={turn},seed={seed}" for turn in (10, 20) for seed in (0, 1)]
    assert [run.name for run in found.runs] == names
    assert list(found.pushes.columns) == ["run", "task.goal.turn_deg", "seed", *COLUMNS]
    assert len(found.pushes) == 16
    for run, (_, rows) in zip(found.runs, found.pushes.groupby("run", sort=False), strict=True):
        assert set(rows["task.goal.turn_deg"]) == {run.config["task"]["goal"]["turn_deg"]}
        pd.testing.assert_frame_equal(rows[COLUMNS].reset_index(drop=True), run.pushes)
    table = found.summary
    assert list(table["run"]) == names
    assert list(table["seed"]) == [0, 1, 0, 1]
    assert list(table["e_T"]) == [run.summary.errors["e_T"] for run in found.runs]


def test_a_sweep_says_what_it_leaves_out(sweep):
    found = deformpush.load(sweep)
    assert found.skipped == {
        "turn=30,seed=0": "no summary.json: it still runs, or was killed",
        "turn=40,seed=0": "not begun",
    }
    assert "skipped turn=40,seed=0: not begun" in found._repr_html_()
    assert found._repr_html_().count("<tr>") == 5
    assert "4 runs, 2 skipped" in repr(found)


def test_a_setting_that_is_a_list_stands_in_every_row(short, tmp_path):
    for name, d in (("a", "[0.01,0.02]"), ("b", "[0.01,0.03]")):
        deformpush.run(*SHORT, f"object.d={d}", folder=tmp_path / name, progress=False)
    column = deformpush.load(tmp_path).pushes["object.d"]
    assert list(column) == [[0.01, 0.02]] * 4 + [[0.01, 0.03]] * 4


def test_where_there_is_no_run_it_says_so(tmp_path):
    with pytest.raises(deformpush.UserError, match=r"no finished run among .*no such folder"):
        deformpush.load(tmp_path / "nowhere")


def test_a_composed_setup_can_be_run(short, tmp_path):
    setup = deformpush.compose(*SHORT, seed=3)
    assert setup.yaml == (short.folder / "config.yaml").read_text(encoding="utf-8")
    made = deformpush.run(setup, folder=tmp_path / "run", progress=False)
    assert without_times(made.folder / "pushes.csv") == without_times(short.folder / "pushes.csv")
    with pytest.raises(TypeError, match="stands alone: give the other settings"):
        deformpush.run(setup, "seed=1")
    with pytest.raises(TypeError, match="stands alone: give the other settings"):
        deformpush.run(setup, seed=1)


def test_values_are_written_as_on_the_command_line():
    setup = deformpush.compose(*SHORT, object="meat", seed=np.int64(7), max_pushes=20)
    assert (setup.options["object"], setup.seed, setup.max_pushes) == ("meat", 7, 20)


def test_without_progress_it_says_nothing(tmp_path, capsys):
    deformpush.run(*SHORT, folder=tmp_path / "run", progress=False)
    assert capsys.readouterr() == ("", "")


def test_your_own_classes_come_from_your_folder(tmp_path):
    (tmp_path / "conf" / "object").mkdir(parents=True)
    mine = "defaults: [rect]\nmaterial: {friction: 0.123}\n"
    (tmp_path / "conf" / "object" / "mine.yaml").write_text(mine, encoding="utf-8")
    setup = deformpush.compose("object=mine", config_dir=tmp_path / "conf")
    assert setup.values["object"]["material"]["friction"] == 0.123
    with pytest.raises(deformpush.UserError, match="--config-dir /nowhere: no such folder"):
        deformpush.run(config_dir="/nowhere")


def test_the_folder_is_named_as_by_the_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runs = [deformpush.run(*SHORT, seed=8, progress=False) for _ in range(3)]
    pattern = yaml.safe_load((conf_dir() / "config.yaml").read_text(encoding="utf-8"))["hydra"]["run"]["dir"]
    for name, value in (("object", "rect"), ("acquisition", "lcb")):
        pattern = pattern.replace(f"${{hydra:runtime.choices.{name}}}", value)
    date, _, time = pattern.replace("${seed}", "8").replace("}", "").partition("/")[2].partition("/")
    for run in runs:
        day, name = run.folder.relative_to(tmp_path / "runs").parts
        assert datetime.strptime(day, date.removeprefix("${now:"))
        assert datetime.strptime(re.sub(r"-\d$", "", name), time.removeprefix("${now:"))
    assert len({run.folder for run in runs}) == 3


def test_a_thread_of_its_own_can_make_a_run(short, tmp_path):
    made: list[deformpush.Run] = []

    def work(name: str) -> None:
        made.append(deformpush.run(*SHORT, seed=3, folder=tmp_path / name, progress=False))

    threads = [threading.Thread(target=work, args=(name,)) for name in "abc"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 3
    for run in made:
        assert without_times(run.folder / "pushes.csv") == without_times(short.folder / "pushes.csv")


def test_hydra_is_left_as_it_was(short):
    GlobalHydra.instance().clear()
    deformpush.compose("seed=1")
    assert not GlobalHydra.instance().is_initialized()


def test_a_run_computes_on_one_thread(monkeypatch, tmp_path):
    def look(*_: object) -> None:
        told.extend(pool["num_threads"] for pool in threadpool_info())
        raise deformpush.UserError("seen enough")

    told: list[int] = []
    before = [pool["num_threads"] for pool in threadpool_info()]
    monkeypatch.setattr(api, "make_run", look)
    with pytest.raises(deformpush.UserError, match="seen enough"):
        deformpush.run(*SHORT, folder=tmp_path)
    assert set(told) == {1}
    assert [pool["num_threads"] for pool in threadpool_info()] == before


def test_the_examples_of_the_page_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) >= 3
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "docs/api.md", "exec"), names)
