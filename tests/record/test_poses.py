"""contours.npz and views.npz give back what was recorded."""

import numpy as np
import pytest

from deformpush.record.folder import RunFolder
from deformpush.record.picture import encode
from deformpush.record.poses import TraceWriter, read_trace, read_views


def test_trace_round_trip(tmp_path, run):
    info, rows = run
    folder = RunFolder(tmp_path)
    writer = TraceWriter(folder, info)
    for row in rows:
        writer.add(row, encode(row.after.image, 240, 85))
    trace = read_trace(folder.contours)
    np.testing.assert_array_equal(trace.contours, [row.after.contour for row in rows])
    np.testing.assert_array_equal(trace.centroids, [row.after.c for row in rows])
    np.testing.assert_array_equal(trace.thetas, [row.after.theta for row in rows])
    np.testing.assert_array_equal(trace.starts[1:], [row.decision.start for row in rows[1:]])
    assert np.isnan(trace.starts[0]).all()
    assert trace.camera == info.camera
    assert trace.goal_theta == info.goal_theta
    scale = rows[0].position_error_m / rows[0].e_c
    np.testing.assert_allclose(trace.error_stops * [scale, np.pi, 1], trace.stops)
    views = read_views(folder.views)
    assert len(views) == len(rows)
    assert views[0].shape == (240, 240, 3)
    centre = tuple(np.round(info.camera.to_px(rows[-1].after.c) / 2).astype(int)[::-1])
    assert np.abs(views[-1][centre].astype(int) - (60, 90, 200)).max() < 10  # RGB, not BGR


def test_files_are_valid_after_every_push(tmp_path, run):
    info, rows = run
    writer = TraceWriter(RunFolder(tmp_path), info)
    for k, row in enumerate(rows[:4]):
        writer.add(row, b"picture")
        assert len(read_trace(tmp_path / "contours.npz").contours) == k + 1


@pytest.mark.parametrize("damage", ["empty", "text", "cut", "array", "other"])
def test_a_damaged_file_is_refused_in_one_line(tmp_path, run, damage):
    info, rows = run
    TraceWriter(RunFolder(tmp_path), info).add(rows[0], encode(rows[0].after.image, 240, 85))
    for name, read in (("contours.npz", read_trace), ("views.npz", read_views)):
        path = tmp_path / name
        if damage == "array":
            with path.open("wb") as file:
                np.save(file, np.zeros(3))
        elif damage == "other":
            np.savez(path, something=np.zeros(3))
        else:
            path.write_bytes({"empty": b"", "text": b"hello", "cut": path.read_bytes()[:-50]}[damage])
        with pytest.raises(ValueError, match="damaged, or not written by a run") as caught:
            read(path)
        assert "\n" not in str(caught.value)
