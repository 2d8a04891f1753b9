"""Run folders as runs leave them, made without a simulator."""

import csv
from pathlib import Path

from deformpush.experiment.recorder import Recorder
from deformpush.push_record import PushRecord, RunInfo
from deformpush.record.folder import RunFolder
from deformpush.record.settings import RecordSettings
from deformpush.record.summary import Status
from tests.record.synthetic import SyntheticRun

CONFIG = """\
object: {{_target_: X, thickness: {thickness}, d: [0.01, {d}]}}
task:
  stop: {{position_m: {position_m}, angle_deg: 7.0, e_gamma: 0.15}}
acq: {{_target_: Y, w: {w}}}
bounds: {{d: [0.01, {d}]}}
record: {{rrd: {rrd}}}
seed: {seed}
options: {{object: {name}, acquisition: lcb, record: "off"}}
"""


def written(
    path: Path, info: RunInfo, rows: list[PushRecord], status: Status = "reached", config: str = ""
) -> RunFolder:
    """Record these states without a recording or figures."""
    folder = RunFolder.create(path, config)
    with Recorder(folder, RecordSettings(rrd=False, figures=False)) as recorder:
        recorder.open(info, rows[0], dict)
        for row in rows[1:]:
            recorder(row)
        recorder.close(status, "as asked", wall_s=1.5)
    return folder


def finished(
    path: Path,
    pushes: int = 3,
    seed: int = 0,
    w: float = 1.0,
    name: str = "rect",
    status: Status = "reached",
    position_m: float = 0.02,
) -> Path:
    """Make a run folder; objects of another name have another thickness and range of d."""
    other = name != "rect"
    text = CONFIG.format(
        seed=seed,
        w=w,
        name=name,
        thickness=0.01 if other else 0.02,
        d=0.045 if other else 0.03,
        rrd=bool(seed),
        position_m=position_m,
    )
    made = SyntheticRun(pushes, seed=seed)
    return written(path, made.info, made.records(), status, text).path


def columns(folder: Path) -> dict[str, list[str]]:
    """The cells of pushes.csv by column, read without the project's own reader."""
    with (folder / "pushes.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers(folder: Path, column: str) -> list[float]:
    """A column of pushes.csv; nan where a cell is empty."""
    return [float(cell or "nan") for cell in columns(folder)[column]]
