"""What several runs of one variant did, push by push: their middle and how far they spread."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from deformpush.record.finished import Error
from deformpush.study.variants import Variant

Array = np.ndarray

QUARTILES = (0.25, 0.5, 0.75)
SAID = "line: median over seeds, band: their middle half; a run that has ended keeps its last error"
"""How a figure with bands says what it shows."""


@dataclass(frozen=True)
class Band:
    """Quartiles of an error after push 0, 1, ... of the longest run; each `(K+1,)`."""

    low: Array
    middle: Array
    high: Array


def band(variant: Variant, error: Error) -> Band:
    """Quartiles over the runs. The runs that have ended count with their last value.

    Otherwise the band would tell only of those that still go on, which are the ones that do badly.
    """
    return Band(*np.quantile(held([run.error(error) for run in variant.runs]), QUARTILES, axis=0))


def held(curves: Sequence[Array]) -> Array:
    """Curves `(n_i,)` as rows `(len(curves), max n_i)`, each kept at its last value."""
    longest = max(len(curve) for curve in curves)
    return np.stack([np.pad(curve, (0, longest - len(curve)), mode="edge") for curve in curves])
