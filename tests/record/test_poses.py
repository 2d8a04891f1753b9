"""contours.npz and views.npz give back what was recorded."""

import numpy as np
import pytest

from deformpush.record.folder import RunFolder
from deformpush.record.poses import PosesWriter, decode, encode, read_pictures, read_poses, read_views


def test_poses_round_trip(tmp_path, run):
    info, rows = run
    folder = RunFolder(tmp_path)
    writer = PosesWriter(folder, info)
    for row in rows:
        writer.add(row, encode(row.view.picture, 240, 85))
    poses = read_poses(folder.contours)
    np.testing.assert_array_equal(poses.contours, [row.view.seen.contour for row in rows])
    np.testing.assert_array_equal(poses.centroids, [row.view.seen.c for row in rows])
    np.testing.assert_array_equal(poses.thetas, [row.view.seen.theta for row in rows])
    np.testing.assert_array_equal(poses.starts[1:], [row.action.path.start for row in rows[1:]])
    np.testing.assert_array_equal(poses.ends[1:], [row.action.path.end for row in rows[1:]])
    assert np.isnan(poses.starts[0]).all()
    assert poses.camera == info.camera
    assert poses.goal_theta == info.target.theta
    np.testing.assert_array_equal(poses.goal_outline, info.target.outline)
    np.testing.assert_allclose(poses.stops, [0.02, np.radians(7), 0.15])
    np.testing.assert_allclose(poses.error_stops * [info.target.length, np.pi, 1], poses.stops)
    views = read_views(folder.views)
    assert len(views) == len(rows)
    assert views[0].shape == (240, 240, 3)
    centre = tuple(np.round(info.camera.to_px(rows[-1].view.seen.c) / 2).astype(int)[::-1])
    assert np.abs(views[-1][centre].astype(int) - (60, 90, 200)).max() < 10  # RGB, not BGR


def test_files_are_valid_after_every_push(tmp_path, run):
    info, rows = run
    writer = PosesWriter(RunFolder(tmp_path), info)
    for k, row in enumerate(rows[:4]):
        writer.add(row, b"picture")
        assert len(read_poses(tmp_path / "contours.npz").contours) == k + 1


@pytest.mark.parametrize("damage", ["empty", "text", "cut", "array", "other"])
def test_a_damaged_file_is_refused_in_one_line(tmp_path, run, damage):
    info, rows = run
    PosesWriter(RunFolder(tmp_path), info).add(rows[0], encode(rows[0].view.picture, 240, 85))
    for name, read in (("contours.npz", read_poses), ("views.npz", read_views)):
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


def test_the_files_hold_what_is_documented(tmp_path, run):
    """Names and shapes, which others read."""
    info, rows = run
    writer = PosesWriter(RunFolder(tmp_path), info)
    for row in rows[:3]:
        writer.add(row, b"abc")
    with np.load(tmp_path / "contours.npz") as file:
        shapes = {name: file[name].shape for name in file.files}
    m, g = len(rows[0].view.seen.contour), len(info.target.outline)
    assert shapes == {
        "contours": (3, m, 2), "centroids": (3, 2), "thetas": (3,), "starts": (3, 2), "ends": (3, 2),
        "goal_c": (2,), "goal_theta": (), "goal_outline": (g, 2), "stops": (3,), "error_stops": (3,),
        "outer_bounds": (2, 2), "camera": (6,),
    }  # fmt: skip
    with np.load(tmp_path / "views.npz") as file:
        assert (file["data"].tobytes(), file["ends"].tolist()) == (b"abc" * 3, [3, 6, 9])
    assert read_pictures(tmp_path / "views.npz") == [b"abc"] * 3


def test_states_kept_are_written_with_the_next(tmp_path, run):
    info, rows = run
    writer = PosesWriter(RunFolder(tmp_path), info)
    writer.keep(rows[0], b"a")
    assert not (tmp_path / "contours.npz").exists()
    writer.add(rows[1], b"b")
    assert len(read_poses(tmp_path / "contours.npz").contours) == 2


def test_a_picture_is_made_smaller_and_never_larger(run):
    image = run[1][0].view.picture
    assert decode(np.frombuffer(encode(image, 100, 85), np.uint8)).shape == (100, 100, 3)
    whole = decode(np.frombuffer(encode(image, 9999, 95), np.uint8))
    assert whole.shape == image.shape
    assert np.abs(whole.astype(int) - image).mean() < 2
