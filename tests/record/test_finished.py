"""A finished run is read as it ended; what cannot be read is refused with the reason (`study.find_runs`)."""

import numpy as np
import pytest

from deformpush.experiment.recorder import Recorder
from deformpush.record.finished import NotFinishedError, flat, read
from deformpush.record.folder import RunFolder
from deformpush.record.settings import RecordSettings
from deformpush.task import TERMS, TOTAL

CONFIG = """\
task:
  stop: {position_m: 0.02, angle_deg: 7.0, e_gamma: 0.15}
acq: {w: 2.0, levels: [1, 2]}
options: {object: rect, acquisition: lcb}
"""


@pytest.fixture
def folder(tmp_path, run):
    info, rows = run
    folder = RunFolder.create(tmp_path, CONFIG)
    with Recorder(folder, RecordSettings(rrd=False, figures=False)) as recorder:
        recorder.open(info, rows[0], dict)
        for row in rows[1:4]:
            recorder(row)
        recorder.close("budget", "spent")
    return folder


def test_errors_are_in_their_units(folder, run):
    found, rows = read(folder, "mine"), run[1][:4]
    assert found.name == "mine"
    position, angle, shape = (found.error(term) for term in TERMS)
    np.testing.assert_allclose(position, [1e3 * row.errors["position_error_m"] for row in rows])
    np.testing.assert_allclose(angle, np.degrees([abs(row.errors["angle_error_rad"]) for row in rows]))
    np.testing.assert_allclose(shape, [row.errors["e_gamma"] for row in rows])
    np.testing.assert_allclose(found.error(TOTAL), [row.errors.e_T for row in rows])


def test_stops_are_in_the_units_of_their_errors(folder):
    found = read(folder, "mine")
    np.testing.assert_allclose([found.stop(term) for term in TERMS], [20.0, 7.0, 0.15])
    assert np.isnan(found.stop(TOTAL)), "nothing stops on it"
    folder.config.write_text("task: {stop: {position_m: none}}\n")
    assert np.isnan([read(folder, "mine").stop(term) for term in TERMS]).all()


def test_settings_and_options_are_apart(folder):
    found = read(folder, "mine")
    assert found.settings["acq.w"] == 2.0
    assert found.settings["acq.levels"] == [1, 2]
    assert found.options == {"object": "rect", "acquisition": "lcb"}
    assert not any(key.startswith("options") for key in found.settings)


def test_a_run_has_a_title_and_a_table(folder):
    found = read(folder, "mine")
    assert found.title == "rect, error model, lcb, seed 0"
    assert list(found.pushes["k"]) == [0, 1, 2, 3]
    assert found.summary.pushes == 3


def test_an_interrupted_run_is_not_finished(folder):
    folder.summary.write_text(folder.summary.read_text().replace('"budget"', '"interrupted"'))
    with pytest.raises(NotFinishedError, match=r"^interrupted after 3 pushes; resume continues it$"):
        read(folder, "mine")
    folder.summary.unlink()
    with pytest.raises(NotFinishedError, match=r"^no summary\.json: it still runs, or was killed$"):
        read(folder, "mine")


def test_keys_become_full_ones():
    assert flat({"a": {"b": {"c": 1}, "d": [2]}, "e": {}}) == {"a.b.c": 1, "a.d": [2]}
