"""What became of the runs of a folder, from their folders alone: for `status`, and sweep.csv."""

import csv
import io
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from deformpush.experiment.sweep import manifest
from deformpush.experiment.sweep.manifest import Job
from deformpush.record.files import write_whole
from deformpush.record.folder import RunFolder
from deformpush.record.status import STATES, RunStatus, run_status
from deformpush.study.find_runs import run_folders
from deformpush.task import ERROR_COLUMNS

TABLE = "sweep.csv"
MEASURES = ("pushes", "seed", *ERROR_COLUMNS)
STRAINS = ("strain_peak", "exceedances")
TIMES = ("wall_s", "step_s", "decide_s")


@dataclass(frozen=True)
class Entry:
    """A run and what its folder tells."""

    job: Job
    is_now: RunStatus


@dataclass(frozen=True)
class Overview:
    """All runs of a folder, begun or not."""

    folder: Path
    entries: list[Entry]
    sweep: bool
    """Whether it is the folder of a sweep."""

    @property
    def counts(self) -> Counter[str]:
        """Runs by state."""
        return Counter(entry.is_now.state for entry in self.entries)

    def time_left_s(self) -> float | None:
        """Seconds until all are done, at the pace of those that are, by as many as run now (or cores).

        None where nothing is left to do or nothing was done yet.
        """
        told = [(entry.is_now.summary or {}).get("wall_s") for entry in self.entries]
        times = [float(seconds) for seconds in told if isinstance(seconds, int | float)]
        left = self.counts["running"] * 0.5 + self.counts["pending"] + self.counts["interrupted"]
        if not times or not left:
            return None
        return left * median(times) / (self.counts["running"] or os.cpu_count() or 1)


def look(folder: Path) -> Overview:
    """Look at every run below `folder`, and those of a sweep that have no folder yet."""
    jobs = {job.name: job for job in manifest.read(folder)}
    for path in run_folders(folder):
        if path != folder or not jobs:
            name = os.path.relpath(path, folder)
            jobs.setdefault(name, Job(name, []))
    entries = [Entry(job, run_status(RunFolder(folder / name))) for name, job in jobs.items()]
    return Overview(folder, entries, (folder / manifest.SWEEP).exists())


def write_table(overview: Overview) -> Path:
    """Write sweep.csv: a row a run, with its overrides, state, reason, and what summary.json says.

    Raises:
        OSError: it cannot be written.
    """
    keys = list(dict.fromkeys(key for e in overview.entries for key, _ in _settings(e.job.overrides)))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "state", "status", "reason", *keys, *_columns(keys)])
    for entry in overview.entries:
        now, settings = entry.is_now, dict(_settings(entry.job.overrides))
        end = now.summary or {}
        told = [end.get(name, "") for name in _columns(keys)]
        head = [entry.job.name, now.state, end.get("status", ""), end.get("reason", now.text)]
        writer.writerow([*head, *(settings.get(key, "") for key in keys), *told])
    path = overview.folder / TABLE
    write_whole(path, text.getvalue().encode())
    return path


def states(overview: Overview) -> list[tuple[str, int, str]]:
    """State, number of runs and a remark, for every state that occurs."""
    remarks = {
        "done": _ends(entry.is_now for entry in overview.entries if entry.is_now.state == "done"),
        "running": _pushes([entry for entry in overview.entries if entry.is_now.state == "running"]),
        "interrupted": "the same command again continues them" if overview.sweep else "resume continues them",
        "failed": "sweep.retry=true makes them once more" if overview.sweep else "",
        "pending": "not begun",
    }
    return [(s, overview.counts[s], remarks.get(s, "")) for s in STATES if overview.counts[s]]


def _columns(keys: Sequence[str]) -> list[str]:
    return [name for name in (*MEASURES, *STRAINS, *TIMES) if name not in keys]


def _settings(overrides: Sequence[str]) -> list[tuple[str, str]]:
    return [(key, value) for key, _, value in (text.partition("=") for text in overrides)]


def _ends(done: Iterable[RunStatus]) -> str:
    found = Counter(str((now.summary or {}).get("status")) for now in done)
    words = {"reached": "reached the goal", "budget": "spent the budget", "damaged": "damaged it"}
    return ", ".join(f"{number} {words.get(status, status)}" for status, number in found.most_common())


def _pushes(running: Sequence[Entry]) -> str:
    made = [f"{entry.is_now.pushes}" for entry in running[:6]]
    return f"pushes so far: {', '.join(made)}{', ...' if len(running) > 6 else ''}" if made else ""
