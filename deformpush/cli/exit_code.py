"""What a run's end means to a shell."""

from deformpush.record.summary import Summary


def exit_code(summary: Summary | None) -> int:
    """0: made to its end, 1: it failed. None stands for a run that was left alone."""
    return int(summary is not None and summary.status == "failed")
