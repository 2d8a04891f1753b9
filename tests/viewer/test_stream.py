"""recording.rrd: what is in it, when, and that it opens whatever ended the run.

What the panels draw is tested panel by panel; `panel`, the timelines all of them use, here.
"""

import signal
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
import rerun as rr

from deformpush.record.pictures import encode
from deformpush.record.settings import RecordSettings
from deformpush.viewer.panel import PUSH, SIM_TIME, columns
from deformpush.viewer.stream import Stream
from tests.record.synthetic import SyntheticRun
from tests.viewer.recording import Contents, record

FORETOLD = ("/motion", "/camera/forecast")
EVERYTHING = {
    "/camera/image",
    "/camera/inside/outline",
    "/camera/inside/tool",
    "/camera/contour",
    "/camera/goal",
    "/camera/effective",
    "/camera/trail",
    "/camera/forecast/centroid",
    "/camera/forecast/angle",
    "/camera/next_push/start",
    "/camera/next_push/arrow",
    "/errors/position",
    "/errors/angle",
    "/errors/shape",
    "/errors/total",
    "/strain",
    "/force",
    "/motion/moved/actual",
    "/motion/moved/predicted",
    "/motion/turned/actual",
    "/motion/turned/predicted",
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


def test_everything_is_recorded(full):
    assert full.contents.entities >= EVERYTHING


def test_outcomes_stand_at_k_and_decisions_at_the_state_they_were_made_in(full):
    times = full.contents.times
    for entity in ("/camera/image", "/camera/contour", "/errors/position", "/xi/actual"):
        assert times(entity, "push") == list(range(13))
        assert [t / 1e9 for t in times(entity, "sim_time")] == [2.0 * k for k in range(13)]
    assert times("/camera/next_push/arrow", "push") == list(range(12))
    assert times("/model/chosen", "push") == [10, 11]


def test_motion_is_on_simulated_time_only(full):
    seconds = [t / 1e9 for t in full.contents.times("/scene/object", "sim_time")]
    moments = [2.0 * k + 0.2 * i for k in range(12) for i in range(1, 6)]
    assert seconds == pytest.approx(sorted([*moments, *(2.0 * k for k in range(13))]))
    assert full.contents.times("/scene/object", "push") == list(range(13))


def test_the_timelines_of_a_batch_are_counts_and_durations():
    push, time = columns({PUSH: [3.0, 4.0], SIM_TIME: [0.5, 1.0]})
    assert push.as_arrow_array().to_pylist() == [3, 4]
    assert time.as_arrow_array().cast("int64").to_pylist() == [500_000_000, 1_000_000_000]


def test_light_leaves_out_the_scene_and_is_small(tmp_path):
    light = record(
        tmp_path / "light",
        SyntheticRun(12, force=True),
        scene=False,
        motion=False,
        image_px=240,
        jpeg_quality=75,
    )
    left_out = ("/scene", "/camera/inside")
    entities = Contents(light).entities
    assert not any(name.startswith(left_out) for name in entities)
    assert entities >= {name for name in EVERYTHING if not name.startswith((*left_out, *FORETOLD))}
    assert light.stat().st_size < 0.6e6


def test_without_motion_the_scene_shows_states_alone(tmp_path):
    contents = Contents(record(tmp_path / "run", SyntheticRun(2), motion=False))
    assert contents.times("/scene/object", "sim_time") == [0, 2_000_000_000, 4_000_000_000]
    assert "/camera/inside/tool" not in contents.entities


def test_without_maps_no_model_is_recorded(tmp_path):
    contents = Contents(record(tmp_path / "run", SyntheticRun(11, mesh=False), maps=False))
    assert not any(name.startswith("/model") for name in contents.entities)


def test_the_recording_bears_the_title_of_the_run(full):
    assert full.contents.fixed("/__properties", "RecordingInfo:name") == [full.info.title]


def test_a_run_taken_up_again_goes_on_where_it_was(tmp_path, full):
    """Panels that keep what was before, such as the trail, are told of the pushes made again."""
    first, *pushes = full.rows
    path = tmp_path / "recording-2.rrd"
    picture = encode(first.view.picture, 480, 85)
    stream = Stream(path, full.info, first, picture, RecordSettings())
    stream.catch_up(pushes[:11])
    stream.push(pushes[11], picture)
    stream.release()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rr.error_utils.RerunWarning)
        part = Contents(path)
    assert part.times("/camera/trail", "push") == [0, 12]
    for entity, component in (
        ("/camera/trail", "LineStrips2D:strips"),
        ("/motion/moved/actual", "Scalars:scalars"),
        ("/motion/moved/predicted", "Scalars:scalars"),
    ):
        assert part.at(entity, component)[12] == full.contents.at(entity, component)[12]
    data = part.at("/model/data", "Points2D:positions")
    assert data == {11: full.contents.at("/model/data", "Points2D:positions")[11]}
    began = full.rows[11].timing.sim_time_s
    assert part.times("/camera/inside/tool", "sim_time")[0] == round(1e9 * (began + 0.2))


def test_sixty_pushes_are_under_ten_megabytes(full):
    """Twelve pushes and the arm's meshes, which are in the file once, take less than a fifth of that."""
    assert full.path.stat().st_size < 2e6


def test_off_writes_no_recording(tmp_path):
    assert not record(tmp_path / "off", SyntheticRun(1), rrd=False).exists()


KILLED = """
import sys, time
from pathlib import Path
from deformpush.record.folder import RunFolder
from deformpush.record.settings import RecordSettings
from deformpush.experiment.recorder import Recorder
from tests.record.synthetic import SyntheticRun
made = SyntheticRun(6)
rows = made.records()
recorder = Recorder(RunFolder.create(Path(sys.argv[1]), ""), RecordSettings())
recorder.open(made.info, rows[0], dict)
for row in rows[1:]:
    recorder(row)
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
    contents = Contents(tmp_path / "run" / "recording.rrd")
    assert contents.times("/camera/image", "push") == list(range(7))
    assert len((tmp_path / "run" / "pushes.csv").read_text().splitlines()) == 8
