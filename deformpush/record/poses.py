"""contours.npz and views.npz: the object's outline, pose and picture after every push."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.push_record import PushRecord, RunInfo
from deformpush.record.files import read_npz, write_npz
from deformpush.record.folder import RunFolder

NOWHERE = np.full(2, np.nan)


class PosesWriter:
    """Rewrites both files at every push, whole, so that they are valid whenever the run stops.

    contours.npz holds, in metres and radians of the table frame:
        contours `(K+1, M, 2)`, centroids `(K+1, 2)`, thetas `(K+1,)`: V_c, c and theta after push k;
        starts, ends `(K+1, 2)`: the tool's path in push k, nan in row 0;
        goal_c `(2,)`, goal_theta `()`, goal_outline `(G, 2)`;
        stops, error_stops: stop values in the order of `TERMS`, in SI units and as errors (1)-(3);
        outer_bounds `(2, 2)`; camera `(6,)`: centre x and y, field, distance, pixels, plane_z.
    views.npz holds `data`, all pictures (JPEG) one after the other, and `ends` `(K+1,)`, where each one ends.
    """

    def __init__(self, folder: RunFolder, info: RunInfo) -> None:
        """Take what stays the same; nothing is written before the first `add`."""
        self._folder = folder
        camera, target = info.camera, info.target
        self._fixed: dict[str, Any] = {
            "camera": (*camera.centre, camera.field, camera.distance, camera.pixels, camera.plane_z),
            "goal_c": target.c,
            "goal_theta": target.theta,
            "goal_outline": target.outline,
            "stops": info.stops(),
            "error_stops": info.error_stops(),
            "outer_bounds": info.outer_bounds,
        }
        self._rows: dict[str, list[Any]] = {
            name: [] for name in ("contours", "centroids", "thetas", "starts", "ends")
        }
        self._views: list[bytes] = []

    def add(self, record: PushRecord, picture: bytes) -> None:
        """Append one state and rewrite both files. `picture` is the encoded bottom view."""
        self.keep(record, picture)
        self._write(sync=False)

    def keep(self, record: PushRecord, picture: bytes) -> None:
        """Append one state without writing, when a run is taken up again."""
        seen, path = record.view.seen, None if record.action is None else record.action.path
        start, end = (NOWHERE, NOWHERE) if path is None else (path.start, path.end)
        now = (seen.contour, seen.c, seen.theta, start, end)
        for values, value in zip(self._rows.values(), now, strict=True):
            values.append(value)
        self._views.append(picture)

    def close(self) -> None:
        """Bring both files to the disk."""
        self._write(sync=True)

    def _write(self, sync: bool) -> None:
        write_npz(self._folder.contours, self._fixed | self._rows, sync)
        data = np.frombuffer(b"".join(self._views), np.uint8)
        ends = np.cumsum([len(view) for view in self._views])
        write_npz(self._folder.views, {"data": data, "ends": ends}, sync)


@dataclass(frozen=True)
class Poses:
    """What contours.npz says; see `PosesWriter` for shapes and units."""

    contours: np.ndarray
    centroids: np.ndarray
    thetas: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    goal_c: np.ndarray
    goal_theta: float
    goal_outline: np.ndarray
    stops: np.ndarray
    error_stops: np.ndarray
    outer_bounds: np.ndarray
    camera: Camera


def read_poses(path: Path) -> Poses:
    """Read contours.npz.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged or no run's; the message is one line that names it.
    """
    arrays = read_npz(path, [item.name for item in fields(Poses)])
    x, y, field, distance, pixels, plane_z = arrays["camera"].tolist()
    arrays["camera"] = Camera((x, y), field, distance, int(pixels), plane_z)
    arrays["goal_theta"] = arrays["goal_theta"].item()
    return Poses(**arrays)


def read_views(path: Path) -> list[np.ndarray]:
    """Decode views.npz: one RGB image `(H, W, 3)` per k; errors as in `read_pictures`."""
    return [decode(np.frombuffer(one, np.uint8)) for one in read_pictures(path)]


def read_pictures(path: Path) -> list[bytes]:
    """Read views.npz: one JPEG per k.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged or no run's; the message is one line that names it.
    """
    arrays = read_npz(path, ["data", "ends"])
    return [one.tobytes() for one in np.split(arrays["data"], arrays["ends"][:-1])]


def encode(image: np.ndarray, width: int, quality: int) -> bytes:
    """JPEG of an RGB image `(H, W, 3)`, scaled down to at most `width` pixels."""
    import cv2

    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    scale = width / bgr.shape[1]
    if scale < 1:
        bgr = cv2.resize(bgr, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return data.tobytes()


def decode(data: np.ndarray) -> np.ndarray:
    """RGB image `(H, W, 3)` of the bytes `(n,)` uint8 of a picture."""
    import cv2

    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR_RGB))
