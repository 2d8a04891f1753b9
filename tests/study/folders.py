"""Run folders as runs leave them, made without a simulator."""

from pathlib import Path

from deformpush.experiment.recorder import Recorder
from deformpush.record.folder import RunFolder
from tests.record.synthetic import SyntheticRun

CONFIG = """\
object: {{_target_: X, thickness: {thickness}, d: [0.01, {d}]}}
task:
  stop: {{position_m: 0.02, angle_deg: 7.0, e_gamma: 0.15}}
acq: {{_target_: Y, w: {w}}}
bounds: {{d: [0.01, {d}]}}
record: {{rrd: {rrd}}}
seed: {seed}
options: {{object: {name}, acquisition: lcb, record: off}}
"""


def finished(
    path: Path, pushes: int = 3, seed: int = 0, w: float = 1.0, name: str = "rect", status: str = "reached"
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
    )
    made = SyntheticRun(pushes, seed=seed)
    rows = made.records()
    folder = RunFolder.create(path, text)
    with Recorder(folder, rrd=False, figures=False) as recorder:
        recorder.open(made.info, rows[0])
        for row in rows[1:]:
            recorder.push(row)
        recorder.close(status, "as asked", wall_s=1.5)
    return path
