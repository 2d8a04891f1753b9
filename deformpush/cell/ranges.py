"""Ranges that settings of several components share: beyond them nothing on a table is meant."""

from typing import Annotated

from annotated_types import Interval

Metre = Annotated[float, Interval(ge=-10, le=10)]
Place = tuple[Metre, Metre]
"""Table frame (m)."""
Side = Annotated[float, Interval(ge=1e-3, le=1)]
"""A length that an object or a push may have (m)."""
HalfLength = Annotated[float, Interval(ge=0.01, le=10)]
"""Of a table (m)."""
Degrees = Annotated[float, Interval(ge=-720, le=720)]
Share = Annotated[float, Interval(ge=0, le=1)]
"""Of a whole (-)."""
Point = tuple[float, float]
"""Of an outline (m)."""
