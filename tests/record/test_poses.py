"""contours.npz and views.npz give back what was recorded, and so does states.bin before they are written."""

import numpy as np
import pytest

from deformpush.record.folder import RunFolder
from deformpush.record.pictures import encode
from deformpush.record.poses import PosesWriter, read_pictures, read_poses, read_views
from deformpush.record.states import state_of
from tests.record.test_states import head

POSES = (
    "contours",
    "centroids",
    "thetas",
    "starts",
    "ends",
    "goal_c",
    "goal_outline",
    "stops",
    "error_stops",
)


def recorded(folder: RunFolder, run, pictures=None, count: int | None = None) -> PosesWriter:
    """A writer that has heard of the first states of a run."""
    info, rows = run
    rows = rows[:count]
    pictures = pictures or [encode(row.view.picture, 240, 85) for row in rows]
    first, *states = map(state_of, rows, pictures)
    writer = PosesWriter(folder, info, [first])
    for state in states:
        writer.add(state)
    return writer


@pytest.mark.parametrize("closed", [False, True], ids=["going on", "closed"])
def test_poses_round_trip(tmp_path, run, closed):
    info, rows = run
    folder = RunFolder(tmp_path)
    writer = recorded(folder, run)
    writer.close() if closed else writer.release()
    names = {"contours.npz", "views.npz"} if closed else {"states.bin"}
    assert {path.name for path in tmp_path.iterdir()} == names
    poses = read_poses(folder.contours)
    np.testing.assert_array_equal(poses.contours, [row.view.seen.contour for row in rows])
    np.testing.assert_array_equal(poses.centroids, [row.view.seen.c for row in rows])
    np.testing.assert_array_equal(poses.thetas, [row.view.seen.theta for row in rows])
    np.testing.assert_array_equal(poses.starts[1:], [row.action.path.start for row in rows[1:]])
    np.testing.assert_array_equal(poses.ends[1:], [row.action.path.end for row in rows[1:]])
    assert np.isnan(poses.starts[0]).all()
    assert np.isnan(poses.ends[0]).all()
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


def test_a_reader_sees_the_same_before_and_after_the_end(tmp_path, run):
    folder = RunFolder(tmp_path)
    writer = recorded(folder, run)
    before, pictures = read_poses(folder.contours), read_pictures(folder.views)
    writer.close()
    after = read_poses(folder.contours)
    for name in POSES:
        one, two = getattr(before, name), getattr(after, name)
        assert (one.dtype, one.shape, one.tobytes()) == (two.dtype, two.shape, two.tobytes()), name
    assert (before.camera, before.goal_theta) == (after.camera, after.goal_theta)
    assert pictures == read_pictures(folder.views)


def test_every_state_can_be_read_at_once(tmp_path, run):
    info, rows = run
    writer = PosesWriter(RunFolder(tmp_path), info, [state_of(rows[0], b"picture")])
    for k, row in enumerate(rows[1:4], start=1):
        writer.add(state_of(row, b"picture"))
        assert len(read_poses(tmp_path / "contours.npz").contours) == k + 1
        assert read_pictures(tmp_path / "views.npz") == [b"picture"] * (k + 1)
    writer.release()


def test_the_files_hold_what_is_documented(tmp_path, run):
    """Names, types, shapes and their order, which others read with numpy alone."""
    info, rows = run
    recorded(RunFolder(tmp_path), run, [b"abc"] * 3, 3).close()
    with np.load(tmp_path / "contours.npz") as file:
        shapes = {name: file[name].shape for name in file.files}
        assert {file[name].dtype.str for name in file.files} == {"<f8"}
        np.testing.assert_array_equal(file["contours"], [row.view.seen.contour for row in rows[:3]])
    m, g = len(rows[0].view.seen.contour), len(info.target.outline)
    assert shapes == {
        "contours": (3, m, 2), "centroids": (3, 2), "thetas": (3,), "starts": (3, 2), "ends": (3, 2),
        "goal_c": (2,), "goal_theta": (), "goal_outline": (g, 2), "stops": (3,), "error_stops": (3,),
        "outer_bounds": (2, 2), "camera": (6,),
    }  # fmt: skip
    with np.load(tmp_path / "views.npz") as file:
        assert (file["data"].tobytes(), file["ends"].tolist()) == (b"abc" * 3, [3, 6, 9])
        assert (file["data"].dtype.str, file["ends"].dtype.str) == ("|u1", "<i8")
    assert read_pictures(tmp_path / "views.npz") == [b"abc"] * 3


def test_a_run_taken_up_again_is_not_read_from_the_files_of_before(tmp_path, run):
    folder = RunFolder(tmp_path)
    recorded(folder, run, count=3).close()
    writer = recorded(folder, run, count=5)
    assert not folder.contours.exists(), "nobody takes it for the newest"
    assert len(read_poses(folder.contours).contours) == len(read_pictures(folder.views)) == 5
    writer.close()
    assert len(read_poses(folder.contours).contours) == 5


@pytest.mark.parametrize("after", ["contours.npz", "views.npz"])
def test_an_end_that_is_cut_short_loses_nothing(tmp_path, run, monkeypatch, after):
    """As by a full disk, or a kill between two files: the states stay until both are written."""
    folder = RunFolder(tmp_path)
    writer = recorded(folder, run)
    pictures, contours = read_pictures(folder.views), read_poses(folder.contours).contours
    whole = PosesWriter.close.__globals__["stream_npz"]

    def full(path, parts):
        if path.name == after:
            raise OSError(28, "No space left on device")
        whole(path, parts)

    monkeypatch.setitem(PosesWriter.close.__globals__, "stream_npz", full)
    with pytest.raises(OSError, match="No space left"):
        writer.close()
    assert folder.states.exists()
    assert read_pictures(folder.views) == pictures
    np.testing.assert_array_equal(read_poses(folder.contours).contours, contours)
    monkeypatch.undo()
    writer.close()
    assert not folder.states.exists()
    assert read_pictures(folder.views) == pictures


def test_states_that_somebody_cut_are_not_taken_for_all(tmp_path, run):
    folder = RunFolder(tmp_path)
    writer = recorded(folder, run)
    folder.states.write_bytes(folder.states.read_bytes()[:-1])
    with pytest.raises(OSError, match="14 of 15 states left"):
        writer.close()
    assert folder.states.exists()


@pytest.mark.parametrize("damage", ["empty", "text", "cut", "array", "other"])
def test_a_damaged_file_is_refused_in_one_line(tmp_path, run, damage):
    recorded(RunFolder(tmp_path), run, count=1).close()
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


def changed(path, **arrays) -> None:
    with np.load(path) as file:
        whole = dict(file)
    np.savez(path, **(whole | arrays))


@pytest.mark.parametrize(
    "arrays",
    [
        {"centroids": np.zeros((4, 2))},
        {"contours": np.zeros((3, 200, 3))},
        {"contours": np.zeros((3, 200, 2), np.float32)},
        {"contours": np.full((3, 200, 2), np.nan)},
        {"thetas": np.full(3, np.inf)},
        {"goal_theta": np.zeros(2)},
        {"camera": np.zeros(5)},
        {"camera": np.zeros(6)},
        {"camera": np.array([0.5, 0, 0.6, 1, 1e9, 0])},
        {"camera": np.array([0.5, 0, 0.6, 1, np.nan, 0])},
        {"stops": np.zeros(2)},
    ],
)
def test_poses_that_are_none_are_one_line(tmp_path, run, arrays):
    recorded(RunFolder(tmp_path), run, count=3).close()
    changed(tmp_path / "contours.npz", **arrays)
    with pytest.raises(ValueError, match="damaged, or not written by a run") as caught:
        read_poses(tmp_path / "contours.npz")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("ends", [[3, 2, 9], [3, 6, 10], [-1, 3, 9], [0, 3, 9], [3, 3, 9], []])
def test_pictures_without_a_place_are_one_line(tmp_path, run, ends):
    recorded(RunFolder(tmp_path), run, [b"abc"] * 3, 3).close()
    changed(tmp_path / "views.npz", ends=np.array(ends, np.int64))
    with pytest.raises(ValueError, match="damaged, or not written by a run"):
        read_pictures(tmp_path / "views.npz")


@pytest.mark.parametrize(
    "content",
    [
        b"",
        head({"M": 4, "fixed": {}}),
        head({"M": 4, "fixed": {"camera": [1], "more": 2}}),
    ],
)
def test_states_of_no_run_are_one_line(tmp_path, content):
    (tmp_path / "states.bin").write_bytes(content)
    with pytest.raises(ValueError, match="damaged, or not written by a run") as caught:
        read_poses(tmp_path / "contours.npz")
    assert "\n" not in str(caught.value)


def test_states_with_another_camera_are_one_line(tmp_path, run):
    folder = RunFolder(tmp_path)
    recorded(folder, run, count=2).release()
    data = folder.states.read_bytes()
    text = data[8 : 8 + int.from_bytes(data[:4], "little")].replace(b'"camera": [', b'"camera": [7, ')
    folder.states.write_bytes(head(text) + data[8 + int.from_bytes(data[:4], "little") :])
    with pytest.raises(ValueError, match=r"camera is float64 \(7,\), not float64 \(6\)"):
        read_poses(folder.contours)
