"""A Rerun viewer without a window: pictures of recordings where there is no display."""

import socket
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import monotonic, sleep
from typing import TypeVar

import numpy as np
from rerun.experimental import ViewerClient

from deformpush.errors import UserError
from deformpush.viewer.compact import reader
from deformpush.viewer.live import program
from deformpush.viewer.panel import PUSH

DRIVERS = [Path(folder, "vulkan/icd.d") for folder in ("/usr/share", "/etc")]
NEEDS = "needs a Vulkan driver (Debian: mesa-vulkan-drivers)"
STARTUP_S, PATIENCE_S, PAUSE_S = 60.0, 180.0, 2.0
BAR = 37
"""Height of the viewer's own bar (px), which is cut off."""
Answer = TypeVar("Answer")
SIZE = (1600, 900)
"""Size of a picture (px): a 16:9 screen."""


def has_driver() -> bool:
    """Whether this machine can draw without a display."""
    return any(path for folder in DRIVERS for path in folder.glob("*.json"))


@contextmanager
def viewer(size: tuple[int, int] = SIZE) -> Iterator[ViewerClient]:
    """A viewer of this size (px) on a free port of this machine, gone when the block is left.

    Raises:
        UserError: it cannot start here.
    """
    if not has_driver():
        raise UserError(f"a picture without a display {NEEDS}")
    port = free_port()
    command = [str(program()), "--headless", "--window-size", f"{size[0]}x{size[1]}", "--port", str(port)]
    command += ["--bind", "127.0.0.1", "--hide-welcome-screen"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            _wait(process, port)
            yield ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
        finally:
            process.terminate()


def free_port() -> int:
    """A port of this machine on which nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def last_push(recording: Path) -> int:
    """The last push a recording knows."""
    last = 0
    for chunk in reader(recording).stream().to_chunks():
        batch = chunk.to_record_batch()
        if PUSH in batch.schema.names:
            last = max(last, *batch.column(PUSH).cast("int64").to_pylist())
    return last


def screenshot(
    recording: Sequence[Path], picture: Path, push: int, size: tuple[int, int] = SIZE
) -> list[str]:
    """Write a PNG of a recording after a push; return what its views complain about, which is nothing.

    Args:
        recording: its parts.
        picture: where to write.
        push: the state after this push.
        size: of the picture (px).

    Raises:
        UserError: no viewer can start here.
    """
    width, height = size
    with viewer((width, height + BAR)) as client:
        for part in recording:
            _patiently(partial(client.open, str(part)))
        _patiently(lambda: client.set_time(PUSH, sequence=push, play_state="paused"))
        _settled(client, picture)
        return _patiently(lambda: complaints(client))


def _settled(client: ViewerClient, picture: Path) -> None:
    """Write the picture once it changes no more: plots have found their scales, notices have gone."""
    import cv2

    before, began = b"", monotonic()
    while True:
        _patiently(lambda: client.save_screenshot(str(picture)))
        if (now := picture.read_bytes()) == before or monotonic() - began > PATIENCE_S:
            break
        before = now
        sleep(PAUSE_S)
    whole = np.asarray(cv2.imread(str(picture)))
    cv2.imwrite(str(picture), whole[BAR:])


def _patiently(call: Callable[[], Answer]) -> Answer:
    """Ask again where the viewer did not answer in time: drawing without a graphics card is slow.

    Raises:
        UserError: it did not answer at all.
    """
    began = monotonic()
    while True:
        try:
            return call()
        except (TimeoutError, ConnectionError) as error:  # or what it was to open is not there yet
            if monotonic() - began > PATIENCE_S:
                raise UserError(f"the headless viewer did not answer in {PATIENCE_S:.0f} s") from error
            sleep(0.2)


def complaints(client: ViewerClient) -> list[str]:
    """What the views report, as `view: report`."""
    return [f"{view.name}: {report}" for view in client.get_state().views for report in view.reports]


def _wait(process: "subprocess.Popen[bytes]", port: int) -> None:
    """Return when the viewer listens."""
    deadline = monotonic() + STARTUP_S
    while process.poll() is None and monotonic() < deadline:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
        except OSError:
            sleep(0.2)
        else:
            return
    raise UserError(f"the headless viewer did not start; it {NEEDS}")
