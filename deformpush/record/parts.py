"""The parts of a recording: a run that was taken up again wrote one file each time."""

from pathlib import Path


def parts(recording: Path) -> list[Path]:
    """The parts that exist, in order: recording.rrd, recording-2.rrd, ..."""
    others = sorted(recording.parent.glob(f"{recording.stem}-*{recording.suffix}"), key=_number)
    return [path for path in [recording, *others] if path.exists()]


def next_part(recording: Path) -> Path:
    """Where the next part goes."""
    there = parts(recording)
    return recording if not there else recording.with_stem(f"{recording.stem}-{_number(there[-1]) + 1}")


def _number(path: Path) -> int:
    number = path.stem.rpartition("-")[2]
    return int(number) if number.isdigit() else 1
