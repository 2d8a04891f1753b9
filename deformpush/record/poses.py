"""contours.npz and views.npz: the object's outline, pose and picture after every push.

Both are written when a run closes. While it goes on, and when it was killed, states.bin has the same, and who
reads gets it from there (see `states`).
"""

import errno
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from pathlib import Path

import numpy as np

from deformpush.cell.camera import Camera
from deformpush.cell.picture_file import MOST_PX
from deformpush.push_record import RunInfo
from deformpush.record.folder import STATES, RunFolder
from deformpush.record.npz import Like, Part, check_like, read_npz, stream_npz
from deformpush.record.pictures import Views
from deformpush.record.states import BEFORE, State, States, StatesWriter

Array = np.ndarray

MOVING: dict[str, tuple[slice, tuple[int | str, ...]]] = {
    "contours": (slice(BEFORE, None), ("M", 2)),
    "centroids": (slice(0, 2), (2,)),
    "thetas": (slice(2, 3), ()),
    "starts": (slice(3, 5), (2,)),
    "ends": (slice(5, 7), (2,)),
}
"""Arrays of contours.npz with a row for each k: where a state has it, and its shape."""
FIXED: dict[str, tuple[int | str, ...]] = {
    "camera": (6,),
    "goal_c": (2,),
    "goal_theta": (),
    "goal_outline": ("G", 2),
    "stops": ("E",),
    "error_stops": ("E",),
    "outer_bounds": (2, 2),
}
"""Arrays of contours.npz that stay the same, and their shapes."""
CONTOURS_LIKE = {name: Like("<f8", shape) for name, shape in FIXED.items()} | {
    name: Like("<f8", ("K+1", *shape)) for name, (_, shape) in MOVING.items()
}
NEVER_NAN = {"contours", "centroids", "thetas", "goal_c", "goal_theta", "goal_outline", "outer_bounds"}
VIEWS_LIKE = {"data": Like("|u1", ("B",)), "ends": Like("<i8", ("K+1",))}


class PosesWriter:
    """Appends states while a run goes on and writes both files when it closes.

    contours.npz holds, in metres and radians of the table frame:
        contours `(K+1, M, 2)`, centroids `(K+1, 2)`, thetas `(K+1,)`: V_c, c and theta after push k;
        starts, ends `(K+1, 2)`: the tool's path in push k, nan in row 0;
        goal_c `(2,)`, goal_theta `()`, goal_outline `(G, 2)`;
        stops, error_stops: stop values in the order of `TERMS`, in SI units and as errors (1)-(3);
        outer_bounds `(2, 2)`; camera `(6,)`: centre x and y, field, distance, pixels, plane_z.
    views.npz holds `data`, all pictures (JPEG) one after the other, and `ends` `(K+1,)`, where each one ends.
    """

    def __init__(self, folder: RunFolder, info: RunInfo, first: Sequence[State]) -> None:
        """Begin states.bin with the states so far, in place of what an earlier part of the run left."""
        camera, target = info.camera, info.target
        fixed = {
            "camera": (*camera.centre, camera.field, camera.distance, camera.pixels, camera.plane_z),
            "goal_c": target.c,
            "goal_theta": target.theta,
            "goal_outline": target.outline,
            "stops": info.stops(),
            "error_stops": info.error_stops(),
            "outer_bounds": info.outer_bounds,
        }
        self._folder = folder
        self._states, self._count = StatesWriter(folder.states, fixed, first), len(first)
        try:
            for path in (folder.contours, folder.views):
                path.unlink(missing_ok=True)
        except OSError:
            self.release()
            raise

    def add(self, state: State) -> None:
        """Append one state.

        Raises:
            OSError: no room for it.
        """
        self._states.append(state)
        self._count += 1

    def close(self) -> None:
        """Write both files, bring them to the disk, and remove states.bin, which has nothing more to tell.

        Raises:
            OSError: no room; states.bin stays.
        """
        self.release()
        states = States(self._folder.states, limited=False)
        if (count := sum(1 for _ in states)) != self._count:
            raise OSError(
                errno.EIO, f"{STATES} was changed from outside: {count} of {self._count} states left"
            )
        stream_npz(self._folder.contours, _contours(states))
        stream_npz(self._folder.views, _views(states))
        self._folder.states.unlink()

    def release(self) -> None:
        """Let go of states.bin as it is."""
        self._states.close()


def _contours(states: States) -> dict[str, Part]:
    """The arrays of contours.npz, read from states.bin once for each of them."""
    count = sum(1 for _ in states)

    def column(where: slice) -> Iterator[bytes]:
        return (state.numbers[where].tobytes() for state in states)

    parts = {name: Part("<f8", value.shape, [value.tobytes()]) for name, value in states.fixed.items()}
    for name, (where, shape) in MOVING.items():
        parts[name] = Part("<f8", (count, *_lengths(shape, states.points)), column(where))
    return parts


def _views(states: States) -> dict[str, Part]:
    """The arrays of views.npz."""
    ends = np.fromiter(accumulate(len(state.picture) for state in states), np.int64)
    pictures = (state.picture for state in states)
    return {
        "data": Part("|u1", (int(ends[-1]),), pictures),
        "ends": Part("<i8", ends.shape, [ends.astype("<i8").tobytes()]),
    }


@dataclass(frozen=True)
class Poses:
    """What contours.npz says; see `PosesWriter` for shapes and units."""

    contours: Array
    centroids: Array
    thetas: Array
    starts: Array
    ends: Array
    goal_c: Array
    goal_theta: float
    goal_outline: Array
    stops: Array
    error_stops: Array
    outer_bounds: Array
    camera: Camera


def read_poses(path: Path) -> Poses:
    """Read contours.npz, or what a run has come to so far from states.bin beside it.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged or no run's; the message is one line that names it.
    """
    states = _so_far(path)
    arrays = read_npz(path, CONTOURS_LIKE) if states is None else _columns(states)
    x, y, field, distance, pixels, plane_z = arrays.pop("camera").tolist()
    known = [value for name, value in arrays.items() if name in NEVER_NAN]
    finite = all(np.isfinite(value).all() for value in known)
    if not (finite and 0 < pixels <= MOST_PX and field > 0 and len(arrays["contours"])):
        raise ValueError(f"{path}: damaged, or not written by a run (numbers that no run has)")
    camera = Camera((x, y), field, distance, int(pixels), plane_z)
    return Poses(goal_theta=arrays.pop("goal_theta").item(), camera=camera, **arrays)


def read_views(path: Path) -> Views:
    """Read views.npz as RGB images `(H, W, 3)`, one per k, decoded when asked for; as `read_pictures`."""
    return Views(read_pictures(path), str(path))


def read_pictures(path: Path) -> list[bytes]:
    """Read views.npz, or states.bin beside it: one JPEG per k.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged or no run's; the message is one line that names it.
    """
    if (states := _so_far(path)) is not None:
        return [state.picture for state in states]
    arrays = read_npz(path, VIEWS_LIKE)
    data, ends = arrays["data"].tobytes(), [0, *arrays["ends"].tolist()]
    if not 0 < ends[-1] <= len(data) or any(a >= b for a, b in pairwise(ends)):
        raise ValueError(f"{path}: damaged, or not written by a run (pictures without a place)")
    return [data[a:b] for a, b in pairwise(ends)]


def _so_far(path: Path) -> States | None:
    """The states beside a file that is not written yet; None where the run was closed."""
    try:
        return States(path.with_name(STATES))
    except FileNotFoundError:
        return None


def _columns(states: States) -> dict[str, Array]:
    """The arrays of contours.npz.

    Raises:
        ValueError: those that stay the same are not like they should be.
    """
    lengths: dict[str, int] = {}
    if set(states.fixed) != set(FIXED):
        raise ValueError(f"{states.path}: damaged, or not written by a run")
    for name, value in states.fixed.items():
        check_like(f"{states.path}: {name}", value.dtype, value.shape, CONTOURS_LIKE[name], lengths)
    numbers = np.array([state.numbers for state in states]).reshape(-1, BEFORE + 2 * states.points)
    arrays = dict(states.fixed)
    for name, (where, shape) in MOVING.items():
        arrays[name] = numbers[:, where].reshape(-1, *_lengths(shape, states.points))
    return arrays


def _lengths(shape: tuple[int | str, ...], points: int) -> list[int]:
    """A shape in numbers."""
    return [points if length == "M" else int(length) for length in shape]
