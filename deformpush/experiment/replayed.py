"""What comes to light while a run's pushes are made again: the same run, other arithmetic, or another run.

A camera looks at what a world does, and what it sees is rounded (`mechanics.rounding`). So a last bit that
differs inside a world does not show at all, until a value lies on the brink between two roundings or an edge
on the brink between two pixels. Hence three sizes: up to a step of rounding, a last bit; up to a pixel, which
is the least that a camera can show and may have grown from a last bit; and more, a real difference.
"""

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import WorldError
from deformpush.experiment.origin import origin
from deformpush.experiment.repeat import in_words, replay, wants
from deformpush.loop import Episode
from deformpush.mechanics import rounding
from deformpush.push_record import PushRecord
from deformpush.record.poses import read_poses
from deformpush.record.summary import counted
from deformpush.record.unfinished import Difference, UnfinishedRun

STEP_M = 1.5 * 10.0**-rounding.METRES
"""A step of the contour's rounding (m), and what is lost by subtracting."""
STEP = 1e-5
"""A step of an error: a share of the first one, which is that of 1 cm or more."""
STEP_U = 1.5 * np.array([10.0**-rounding.KAPPA, 10.0**-rounding.DISTANCE])
"""A step of a push (kappa, d)."""


class Replay:
    """Follows an episode through the pushes that were recorded."""

    def __init__(self, episode: Episode, recorded: UnfinishedRun) -> None:
        """Take a run where it is, before its first push or later, and what there is of it."""
        self.episode, self.recorded = episode, recorded
        self._begins = episode.record.k
        self._contours = _contours(recorded)
        self._first: str | None = None
        self._at, self._size = 0, ""
        self._pixel_m = 1.1 * episode.cell.camera.field / episode.cell.camera.pixels
        self._largest, self._largest_at = 0.0, 0
        self._otherwise: str | None = None
        self._otherwise_at = 0
        self._failed: str | None = None

    def follow(self, maps: bool) -> Iterator[PushRecord]:
        """Make the pushes one after the other and keep what is different; a push that fails is the last."""
        try:
            yield from self._followed(maps)
        except (WorldError, PerceptionError) as problem:
            self._failed = f"fails at push {self.episode.record.k + 1}, which was made then: {problem}"

    def _followed(self, maps: bool) -> Iterator[PushRecord]:
        for record, others in replay(self.episode, self.recorded, maps):
            apart = self._apart(record)
            if apart > self._largest:
                self._largest, self._largest_at = apart, record.k
            if self._first is None and (others or apart):
                self._at = record.k
                self._first = _words(others, apart)
                self._size = self._sized(others, apart)
            if record.k and self._otherwise is None:
                self._decision(record.k)
            yield record

    @property
    def identical(self) -> bool:
        """Whether nothing differed."""
        return self._first is None and self._otherwise is None and self._failed is None

    def text(self) -> str:
        """What to say: how the states went, how the decisions, and what may be the reason."""
        lines = [self._states()]
        if self._failed is not None:
            lines.append(self._failed)
        if self._otherwise is not None:
            lines.append(f"decides otherwise: {self._otherwise}")
        elif self._first is not None and not self._begins:
            lines.append("decides the same at every push")
        if not self.identical:
            at = self._at or self._otherwise_at or self.episode.record.k + 1
            lines.append(origin(self.recorded.folder, at))
        return "\n".join(lines)

    def _states(self) -> str:
        pushes = counted(self.episode.record.k - self._begins)
        seen = len(self._contours) > 0
        if self._first is None:
            return f"identical: {pushes}, errors{' and contours' if seen else ''} to the last bit"
        text = f"differs {self._size}, first at push {self._at}: {self._first}"
        if seen and self._largest_at > self._at:
            return f"{text}; grows to {_length(self._largest)} at push {self._largest_at}; {pushes} compared"
        return f"{text}; grows no further in {pushes}" if seen else f"{text}; {pushes} compared"

    def _sized(self, others: list[Difference], apart: float) -> str:
        """How large a difference of a state is; the contour decides where one was recorded."""
        if apart <= STEP_M and all(other.size <= STEP for other in others):
            return "in the last bit"
        return "by a pixel at most" if 0 < apart <= self._pixel_m else "really"

    def _decision(self, k: int) -> None:
        """Compare what the optimizer chose for push k with the push that was made."""
        made, u = self.episode.wanted, self.recorded.proposal(k).u
        if made is None or np.array_equal(made, u):
            return
        kind = "by a step of its rounding" if (np.abs(made - u) <= STEP_U).all() else "really"
        self._otherwise_at = k
        self._otherwise = (
            f"{kind}, first at push {k}: the optimizer {wants(self.episode)}, it pushed {in_words(u)}"
        )

    def _apart(self, record: PushRecord) -> float:
        """The largest distance of a contour point from the recorded one (m); 0 where none was recorded."""
        if record.k >= len(self._contours):
            return 0.0
        return float(np.linalg.norm(record.view.seen.contour - self._contours[record.k], axis=1).max())


def _words(others: list[Difference], apart: float) -> str:
    """The first difference of a state, and its size."""
    parts = [f"the contour by {_length(apart)}"] if apart else []
    if others:
        worst = max(others, key=lambda other: other.size)
        size = f" (by {worst.size:.2g})" if np.isfinite(worst.size) else ""
        parts.append(f"{worst}{size}")
    return ", ".join(parts)


def _contours(recorded: UnfinishedRun) -> Any:
    """The recorded contours `(K+1, M, 2)`, or none where they cannot be read."""
    try:
        return read_poses(recorded.folder.contours).contours
    except FileNotFoundError:
        return ()
    except (OSError, ValueError) as error:
        print(f"without the contours: {error}", file=sys.stderr)
        return ()


def _length(metres: float) -> str:
    return f"{metres * 1e3:.3g} mm" if metres > STEP_M else f"{metres:.1g} m"
