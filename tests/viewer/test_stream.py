"""recording.rrd: what is in it, when, and that it opens whatever ended the run."""

import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from rerun.chunk import RrdReader

from deformpush.experiment.recorder import Recorder
from deformpush.record.folder import RunFolder
from deformpush.viewer.text import chosen
from tests.record.synthetic import SyntheticRun, kuka

EVERYTHING = {
    "/camera/image",
    "/camera/inside/outline",
    "/camera/inside/tool",
    "/camera/contour",
    "/camera/goal",
    "/camera/effective",
    "/camera/trail",
    "/camera/next_push/start",
    "/camera/next_push/arrow",
    "/errors/position",
    "/errors/angle",
    "/errors/shape",
    "/errors/total",
    "/actions/kappa",
    "/actions/d",
    "/actions/kappa/bounds",
    "/actions/d/bounds",
    "/xi/actual",
    "/xi/predicted",
    "/phase",
    "/model/mean/map",
    "/model/std/map",
    "/model/acq/map",
    "/model/data",
    "/model/bounds",
    "/model/chosen",
    "/scene/table",
    "/scene/object",
    "/scene/joints",
    "/scene/next_push",
    "/about",
    "/config",
    "/now",
}


def chunks(path: Path) -> list:
    return list(RrdReader(str(path)).stream().to_chunks())


def times(path: Path, entity: str, timeline: str) -> list[int]:
    """Values of a timeline at an entity, in order; static rows and rows without it are left out."""
    found = []
    for chunk in chunks(path):
        batch = chunk.to_record_batch()
        if str(chunk.entity_path) == entity and timeline in batch.schema.names:
            found += batch.column(timeline).cast("int64").to_pylist()
    return sorted(found)


def record(folder: Path, made: SyntheticRun, **options) -> Path:
    rows = made.records()
    with Recorder(RunFolder.create(folder, ""), figures=False, **options) as recorder:
        recorder.open(made.info, rows[0])
        for row in rows[1:]:
            recorder.push(row)
        recorder.close("reached", "all errors")
    return folder / "recording.rrd"


@pytest.fixture(scope="module")
def full(tmp_path_factory) -> Path:
    return record(tmp_path_factory.mktemp("run") / "full", SyntheticRun(12, urdf=kuka()))


def test_everything_is_recorded(full):
    assert {str(chunk.entity_path) for chunk in chunks(full)} >= EVERYTHING


def test_each_link_of_the_description_leads_to_something(full):
    texts = [chunk.to_record_batch() for chunk in chunks(full) if str(chunk.entity_path) == "/about"]
    text = texts[0].column("TextDocument:text").to_pylist()[0][0]
    links = re.findall(r"recording:/(/[^)]+)\)", text)
    assert len(links) > 15
    assert set(links) <= {str(chunk.entity_path) for chunk in chunks(full)}


def test_outcomes_stand_at_k_and_decisions_at_the_state_they_were_made_in(full):
    assert times(full, "/camera/contour", "push") == list(range(13))
    assert times(full, "/errors/position", "push") == list(range(13))
    assert times(full, "/xi/actual", "push") == list(range(13))
    assert times(full, "/camera/next_push/arrow", "push") == list(range(12))
    assert times(full, "/model/chosen", "push") == [10, 11]


def test_motion_is_on_simulated_time_only(full):
    seconds = [t / 1e9 for t in times(full, "/scene/object", "sim_time")]
    moments = [2.0 * k + 0.2 * i for k in range(12) for i in range(1, 6)]
    for entity in ("/camera/inside/outline", "/camera/inside/tool"):
        assert [t / 1e9 for t in times(full, entity, "sim_time")] == pytest.approx(moments)
        assert times(full, entity, "push") == []
    assert seconds == pytest.approx(sorted([*moments, *(2.0 * k for k in range(13))]))
    assert times(full, "/scene/object", "push") == list(range(13))
    assert len(times(full, "/scene/joints", "push")) == 7 * 13
    assert len(times(full, "/scene/joints", "sim_time")) == 7 * (13 + 60)


def test_light_leaves_out_the_scene_and_is_small(tmp_path):
    light = record(
        tmp_path / "light", SyntheticRun(12), scene=False, motion=False, image_px=240, jpeg_quality=75
    )
    entities = {str(chunk.entity_path) for chunk in chunks(light)}
    left_out = ("/scene", "/camera/inside")
    assert not any(name.startswith(left_out) for name in entities)
    assert entities >= {name for name in EVERYTHING if not name.startswith(left_out)}
    assert light.stat().st_size < 0.6e6


def test_the_strip_of_strain_is_there_where_it_is_measured(tmp_path, full):
    assert times(full, "/strain", "push") == list(range(13))
    unmeasured = record(tmp_path / "plain", SyntheticRun(2, mesh=False))
    assert "/strain" not in {str(chunk.entity_path) for chunk in chunks(unmeasured)}


def test_a_bare_tool_is_drawn_without_an_arm(tmp_path):
    tool = record(tmp_path / "tool", SyntheticRun(2))
    entities = {str(chunk.entity_path) for chunk in chunks(tool)}
    assert "/scene/tool" in entities
    assert "/scene/joints" not in entities


def test_sixty_pushes_are_under_ten_megabytes(full):
    """Twelve pushes and the arm's meshes, which are in the file once, take less than a fifth of that."""
    assert full.stat().st_size < 2e6


def test_off_writes_no_recording(tmp_path):
    assert not record(tmp_path / "off", SyntheticRun(1), rrd=False).exists()


KILLED = """
import sys, time
from pathlib import Path
from deformpush.record.folder import RunFolder
from deformpush.experiment.recorder import Recorder
from tests.record.synthetic import SyntheticRun
made = SyntheticRun(6)
rows = made.records()
recorder = Recorder(RunFolder.create(Path(sys.argv[1]), ""))
recorder.open(made.info, rows[0])
for row in rows[1:]:
    recorder.push(row)
    time.sleep(0.2)
print("pushed", flush=True)
time.sleep(60)
"""


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_the_recording_of_a_killed_run_opens_up_to_its_last_push(tmp_path):
    command = [sys.executable, "-c", KILLED, str(tmp_path / "run")]
    root = Path(__file__).parents[2]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=root) as process:
        assert process.stdout.readline() == "pushed\n"
        process.send_signal(signal.SIGKILL)
    assert times(tmp_path / "run" / "recording.rrd", "/camera/image", "push") == list(range(7))
    assert len((tmp_path / "run" / "pushes.csv").read_text().splitlines()) == 8


def test_a_viewer_that_is_not_there_does_not_hold_up_the_run(tmp_path, caplog):
    nobody = "rerun+http://127.0.0.1:9/proxy"
    path = record(tmp_path / "run", SyntheticRun(2), connect=nobody)
    assert f"record.connect={nobody}: no viewer answers; the run goes on without one" in caplog.text
    assert times(path, "/camera/image", "push") == [0, 1, 2]


def test_a_window_that_cannot_open_does_not_hold_up_the_run(tmp_path, caplog, monkeypatch):
    """As where there is no display: the program ends at once."""
    monkeypatch.setattr("deformpush.viewer.live.WINDOWS", [])
    monkeypatch.setattr("deformpush.viewer.live.program", lambda: shutil.which("false"))
    monkeypatch.setattr("deformpush.viewer.live.SPAWNED", "rerun+http://127.0.0.1:9/proxy")
    path = record(tmp_path / "run", SyntheticRun(2), spawn=True)
    assert "record.spawn=true: no viewer answers; the run goes on without one" in caplog.text
    assert times(path, "/camera/image", "push") == [0, 1, 2]


def test_the_speed_of_a_push_is_said_where_it_is_chosen():
    decision = SyntheticRun(1, mesh=False).records()[1].decision
    assert "m/s" not in chosen(replace(decision, speed=float("nan")))
    assert "d **" in chosen(decision)
    assert ", at **0.052 m/s**" in chosen(replace(decision, speed=0.0522))


@pytest.mark.parametrize(
    "address", ["127.0.0.1:9876", "http://127.0.0.1:9876/proxy", "rerun://host/proxy", ""]
)
def test_an_address_that_is_none_is_refused_by_name(tmp_path, address):
    with pytest.raises(ValueError, match=r"^connect: .* is no address of a viewer, such as rerun"):
        Recorder(RunFolder(tmp_path), connect=address)
