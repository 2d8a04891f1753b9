"""The run folder: one run's files, each whole or absent, none ever overwritten by another run."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np

from deformpush.errors import UserError
from deformpush.record.files import write_whole
from deformpush.record.kernels import kernels
from deformpush.record.lock import Lock
from deformpush.record.provenance import provenance, read_provenance

CONFIG = "config.yaml"
PROVENANCE = "provenance.json"
TABLE = "pushes.csv"
FORECASTS = "forecasts.csv"
CONTOURS = "contours.npz"
VIEWS = "views.npz"
STATES = "states.bin"
"""What the two before are made of when a run closes."""
WORLD_STATES = "world_states.bin"
SUMMARY = "summary.json"
RECORDING = "recording.rrd"
CHECKPOINT = "checkpoint.npz"
FIGURES = "figures"
LOG = "deformpush.log"
REFUSED = "refused.txt"
"""Why a run of a sweep never began; it does not make the folder taken."""

RESULTS = (
    CONFIG,
    PROVENANCE,
    TABLE,
    FORECASTS,
    CONTOURS,
    VIEWS,
    STATES,
    WORLD_STATES,
    SUMMARY,
    RECORDING,
    CHECKPOINT,
    FIGURES,
)
"""What makes a folder taken. Hydra's own `.hydra/` and log come before the run and do not count."""


class FolderError(UserError):
    """The run folder cannot be used; the message is one line that names the key."""


@dataclass(frozen=True)
class RunFolder:
    """The paths of one run's files and the two ways to write them."""

    path: Path
    config_yaml: str = ""
    """What config.yaml will hold in a new folder."""

    @classmethod
    def create(cls, path: str | Path, config_yaml: str) -> "RunFolder":
        """Make sure that a run can be written to `path`. Nothing is in it before `claim`.

        Raises:
            FolderError: the folder holds results, or cannot be written.
        """
        folder = cls(Path(path), config_yaml)
        try:
            folder.path.mkdir(parents=True, exist_ok=True)
            folder._refuse(folder._taken())
            with TemporaryFile(dir=folder.path):
                pass
        except OSError as error:
            raise folder._not_writable(error) from error
        return folder

    def claim(self) -> Lock:
        """Take the folder for the run that begins now and write what is known of it.

        Returns:
            The folder's lock, to be held as long as the run writes to it.

        Raises:
            FolderError: another run was quicker, or the folder cannot be written.
        """
        lock = self.lock()
        try:
            self._refuse(self._taken())
            # First, so that a run killed from here on has all that continuing it takes.
            self.write(CONFIG, self.config_yaml.encode())
            self.furnish()
        except BaseException as error:
            lock.release()
            if isinstance(error, OSError):
                raise self._not_writable(error) from error
            raise
        return lock

    def furnish(self) -> None:
        """Lay out what a claimed folder holds before the first row, also where a killed run had begun to.

        Raises:
            FolderError: the folder cannot be written.
        """
        try:
            self.figures.mkdir(exist_ok=True)
            self.write_json(PROVENANCE, provenance())
        except OSError as error:
            raise self._not_writable(error) from error

    def lock(self) -> Lock:
        """Make sure that no other process works here, and that what is written here stays here.

        Raises:
            FolderError: one does, there is a link to elsewhere, or the folder cannot be written.
        """
        try:
            self._refuse_links()
            lock = Lock.take(self.path)
        except OSError as error:
            raise self._not_writable(error) from error
        if lock is None:
            raise FolderError(f"{self.path}: another process is at work in this folder")
        return lock

    def note_resumption(self, pushes: int) -> None:
        """Write down that the run goes on after so many pushes: where, when and with which code.

        Raises:
            FolderError: the folder cannot be written.
        """
        try:
            known = read_provenance(self.path / PROVENANCE)
        except (OSError, ValueError):
            known = {}
        parts = [*known.pop("resumed", []), {"after": pushes, **provenance()}]
        try:
            self.write_json(PROVENANCE, {**known, "resumed": parts})
            self.summary.unlink(missing_ok=True)
            for leftover in self.path.glob(".*.tmp.*"):  # of a process that was killed while it wrote
                leftover.unlink()
        except OSError as error:
            raise self._not_writable(error) from error

    def note_kernels(self) -> None:
        """Write down the kernels of libraries that were loaded since: scipy comes with the first decision.

        Raises:
            OSError: the file cannot be read or written.
            ValueError: it is damaged.
        """
        known = read_provenance(self.path / PROVENANCE)
        part = known["resumed"][-1] if known.get("resumed") else known
        if part.get("kernels") != (now := kernels()):
            part["kernels"] = now
            self.write_json(PROVENANCE, known)

    def _taken(self) -> list[str]:
        """Results that are here, links to nowhere included."""
        return [name for name in RESULTS if os.path.lexists(self.path / name)]

    def _refuse_links(self) -> None:
        """Refuse a folder with a link in it: what is written here must not go elsewhere.

        Raises:
            FolderError: names the link.
        """
        for folder in (self.path, self.figures):
            entries = sorted(folder.iterdir()) if folder.is_dir() else []
            for entry in entries:
                if entry.is_symlink():
                    raise FolderError(
                        f"{entry}: a symbolic link, and a run writes only into its own folder; remove it, "
                        "or copy what it leads to"
                    )

    def _refuse(self, taken: list[str]) -> None:
        if taken:
            raise FolderError(
                f"hydra.run.dir = {self.path}: this folder already holds results ({', '.join(taken)}); "
                "give a new or empty one"
            )

    def _not_writable(self, error: OSError) -> FolderError:
        return FolderError(f"hydra.run.dir = {self.path}: cannot write there ({error.strerror})")

    @property
    def config(self) -> Path:
        """The resolved configuration."""
        return self.path / CONFIG

    @property
    def table(self) -> Path:
        """One row per push."""
        return self.path / TABLE

    @property
    def contours(self) -> Path:
        """Contours, poses and push points (see `deformpush.record.poses`)."""
        return self.path / CONTOURS

    @property
    def views(self) -> Path:
        """The bottom view after every push."""
        return self.path / VIEWS

    @property
    def states(self) -> Path:
        """The same as far as an unfinished run came (see `deformpush.record.states`)."""
        return self.path / STATES

    @property
    def world_states(self) -> Path:
        """What the world was after every push (see `deformpush.record.world_states`)."""
        return self.path / WORLD_STATES

    @property
    def summary(self) -> Path:
        """How the run ended; absent while it runs."""
        return self.path / SUMMARY

    @property
    def recording(self) -> Path:
        """The Rerun recording."""
        return self.path / RECORDING

    @property
    def checkpoint(self) -> Path:
        """What the optimizer knew after the last push (see `deformpush.record.checkpoint`)."""
        return self.path / CHECKPOINT

    @property
    def figures(self) -> Path:
        """Folder of the PNG figures."""
        return self.path / FIGURES

    def write(self, name: str, data: bytes, sync: bool = True) -> None:
        """Write one file of the folder, whole or not at all."""
        write_whole(self.path / name, data, sync)

    def write_json(self, name: str, values: Mapping[str, Any]) -> None:
        """Write a mapping as JSON that people can read; numbers that are not finite become null."""
        text = json.dumps({key: _plain(value) for key, value in values.items()}, indent=2, allow_nan=False)
        self.write(name, text.encode() + b"\n")


def parts(recording: Path) -> list[Path]:
    """The files of a recording, in order: recording.rrd, recording-2.rrd, ...; resuming a run begins one."""
    others = sorted(recording.parent.glob(f"{recording.stem}-*{recording.suffix}"), key=_number)
    return [path for path in [recording, *others] if path.exists()]


def next_part(recording: Path) -> Path:
    """Where the next part goes."""
    there = parts(recording)
    return recording if not there else recording.with_stem(f"{recording.stem}-{_number(there[-1]) + 1}")


def _number(path: Path) -> int:
    number = path.stem.rpartition("-")[2]
    return int(number) if number.isdigit() else 1


def _plain(value: Any) -> Any:
    """Make a value fit for strict JSON."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
