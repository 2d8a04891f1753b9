"""What regret.csv says in a few lines."""

from pathlib import Path

import numpy as np

from deformpush.record.regret_table import Columns
from deformpush.record.summary import counted


def text(run: Path, rows: Columns) -> str:
    """Gain, regret, rank and calibration of a run, in words."""
    xi, best, tried = (np.array(rows[name], float) for name in ("xi", "xi_best", "xi_tried"))
    regret, rank, trials = (np.array(rows[name]) for name in ("regret", "rank", "trials"))
    failed = int(np.sum(rows["failed"]))
    lines = [
        f"regret of {run}: {counted(len(xi))}, each beside {trials[0]} others from the same state",
        f"gain:        {_gain(xi, best, tried)}",
        f"regret:      mean {regret.mean():.4f} a push, largest {regret.max():.4f} at push "
        f"{rows['k'][int(np.argmax(regret))]}, together {rows['cumulative_regret'][-1]:.4f} (units of e_T)",
        f"rank:        median {np.median(rank):g} of {trials[0] + 1}; best {int(np.sum(rank == 1))} times",
        f"calibration: {_calibration(rows)}",
    ]
    if failed:
        lines.append(f"failed:      {failed} of {trials.sum()} trials: out of reach, or out of the picture")
    return "\n".join(lines)


def _gain(xi: np.ndarray, best: np.ndarray, tried: np.ndarray) -> str:
    """Shares of what the best pushes would have gained."""
    if not best.sum() < 0.0:
        return "no push that was tried would have helped"
    share = f"{xi.sum() / best.sum():.0%} of what the best push would have gained each time"
    mean = np.nansum(tried) / best.sum()
    return f"{share} (those tried, on average: {mean:.0%})"


def _calibration(rows: Columns) -> str:
    """How many outcomes lay where they were expected, in the initial phase and later."""
    inside, initial = np.array(rows["inside_95"], float), np.array(rows["phase"]) == "initial"
    parts = (("in the initial phase ", initial), ("later " if initial.any() else "", ~initial))
    told = [
        name + _of_pushes(rows, known) for name, part in parts if (known := part & np.isfinite(inside)).any()
    ]
    return "\n             ".join(told) or "no forecasts, the optimizer has no model of all pushes"


def _of_pushes(rows: Columns, chosen: np.ndarray) -> str:
    """Calibration over some of the pushes."""
    inside, z_mean, z_rms, tau = (
        np.array(rows[name], float)[chosen] for name in ("inside_95", "z_mean", "z_rms", "kendall_tau")
    )
    count = (np.array(rows["trials"]) - np.array(rows["failed"]))[chosen]
    share, mean, square = (float(np.average(x, weights=count)) for x in (inside, z_mean, z_rms**2))
    return (
        f"{share:.0%} of {count.sum()} outcomes inside their 95% intervals, z has mean {mean:.2f} "
        f"and rms {square**0.5:.2f} (ideal 0 and 1), Kendall's tau {np.nanmean(tau):.2f}"
    )
