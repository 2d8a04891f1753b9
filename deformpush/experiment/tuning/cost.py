"""What a run costs, in pushes: the number that a tuning makes small."""

from deformpush.errors import TroubleError
from deformpush.record import table
from deformpush.record.folder import RunFolder
from deformpush.record.status import run_status


def cost(folder: RunFolder, budget: int) -> float:
    """Pushes to the goal; more than the budget for a run that did not arrive.

    A run that spent its budget costs budget * (1 + min(1, e_T(K) / e_T(0))): once for the pushes it made,
    and once more by the share of the error that is left. So whatever arrives is better than whatever does
    not, and where nothing arrives yet, what comes nearer is better; a constant would tell such trials
    nothing. A run that failed costs twice the budget, as one that came no nearer.

    Raises:
        TroubleError: the run did not come to its end.
    """
    now = run_status(folder)
    if now.state == "failed":
        return 2.0 * budget
    if now.state != "done" or now.summary is None:
        raise TroubleError(f"{folder.path}: did not come to its end: {now.text}")
    if now.summary["status"] == "reached":
        return float(now.pushes)
    at_start, at_end = (table.read_rows(folder.table)[k]["e_T"] for k in (0, -1))
    return budget * (1.0 + min(1.0, at_end / at_start))
