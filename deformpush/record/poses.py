"""contours.npz and views.npz: the object's outline, pose and picture after every push."""

import io
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.push_record import PushRecord, RunInfo
from deformpush.record.folder import CONTOURS, VIEWS, RunFolder
from deformpush.record.picture import decode

NOWHERE = np.full(2, np.nan)


class TraceWriter:
    """Rewrites both files at every push, whole, so that they are valid whenever the run stops.

    contours.npz holds, in metres and radians of the table frame:
        contours `(K+1, M, 2)`, centroids `(K+1, 2)`, thetas `(K+1,)`: V_c, c and theta after push k;
        starts, ends `(K+1, 2)`: the tool's path in push k, nan in row 0;
        goal_c `(2,)`, goal_theta `()`, goal_outline `(G, 2)`;
        stops `(3,)`: position (m), angle (rad), e_gamma; error_stops `(3,)`: e_c, e_theta, e_gamma;
        outer_bounds `(2, 2)`; camera `(6,)`: centre x and y, field, distance, pixels, plane_z.
    views.npz holds `data`, all pictures (JPEG) one after the other, and `ends` `(K+1,)`, where each one ends.
    """

    def __init__(self, folder: RunFolder, info: RunInfo) -> None:
        """Start two empty traces; nothing is written before the first `add`."""
        self._folder, self._info = folder, info
        camera = info.camera
        self._fixed: dict[str, Any] = {
            "camera": (*camera.centre, camera.field, camera.distance, camera.pixels, camera.plane_z),
            "goal_c": info.goal_c,
            "goal_theta": info.goal_theta,
            "goal_outline": info.goal_outline,
            "stops": (info.stop_position_m, info.stop_angle_rad, info.stop_e_gamma),
            "outer_bounds": info.outer_bounds,
        }
        self._rows: list[PushRecord] = []
        self._views: list[bytes] = []

    def add(self, record: PushRecord, picture: bytes) -> None:
        """Append one state and rewrite both files. `picture` is the encoded bottom view."""
        self.keep(record, picture)
        self._write(sync=False)

    def keep(self, record: PushRecord, picture: bytes) -> None:
        """Append one state without writing, when a run is taken up again."""
        if not self._rows:
            self._fixed["error_stops"] = self._info.stop_errors(record)
        self._rows.append(record)
        self._views.append(picture)

    def close(self) -> None:
        """Bring both files to the disk."""
        self._write(sync=True)

    def _write(self, sync: bool) -> None:
        decisions = [row.decision for row in self._rows]
        arrays = self._fixed | {
            "contours": [row.after.contour for row in self._rows],
            "centroids": [row.after.c for row in self._rows],
            "thetas": [row.after.theta for row in self._rows],
            "starts": [NOWHERE if u is None or u.start is None else u.start for u in decisions],
            "ends": [NOWHERE if u is None or u.end is None else u.end for u in decisions],
        }
        self._save(CONTOURS, arrays, sync)
        data = np.frombuffer(b"".join(self._views), np.uint8)
        self._save(VIEWS, {"data": data, "ends": np.cumsum([len(view) for view in self._views])}, sync)

    def _save(self, name: str, arrays: dict[str, Any], sync: bool) -> None:
        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **arrays)
        self._folder.write(name, buffer.getvalue(), sync)


@dataclass(frozen=True)
class Trace:
    """What contours.npz says; see `TraceWriter` for shapes and units."""

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


def read_trace(path: Path) -> Trace:
    """Read contours.npz.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged or no trace of a run; the message is one line that names it.
    """
    arrays = _load(path, [item.name for item in fields(Trace)])
    x, y, field, distance, pixels, plane_z = arrays["camera"].tolist()
    arrays["camera"] = Camera((x, y), field, distance, int(pixels), plane_z)
    arrays["goal_theta"] = arrays["goal_theta"].item()
    return Trace(**arrays)


def read_views(path: Path) -> list[np.ndarray]:
    """Decode views.npz: one RGB image `(H, W, 3)` per k; errors as in `read_pictures`."""
    return [decode(np.frombuffer(one, np.uint8)) for one in read_pictures(path)]


def read_pictures(path: Path) -> list[bytes]:
    """Read views.npz: one JPEG per k.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged or no views of a run; the message is one line that names it.
    """
    arrays = _load(path, ["data", "ends"])
    return [one.tobytes() for one in np.split(arrays["data"], arrays["ends"][:-1])]


def _load(path: Path, names: list[str]) -> dict[str, Any]:
    try:
        with path.open("rb") as handle, np.load(handle, allow_pickle=False) as file:
            return {name: file[name] for name in names}
    except (BadZipFile, EOFError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: damaged, or not written by a run ({error})") from error
